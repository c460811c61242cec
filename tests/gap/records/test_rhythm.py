"""What repeats as the motion does is no disturbance from outside, however well its wave fits."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.effects.registry import effect_named
from stribeck.gap.records.rhythm import rhythm
from stribeck.identify.conditioning import Conditioned, condition
from stribeck.model.scale import Scale
from stribeck.run import Run

from ..conftest import TRUE, sines

HERTZ = 1.6
SCALE = Scale(torque=1.0, friction=0.1, speed=1.0, travel=1.0, inertia=1.0, sample_time=0.005)


def swung(hertz: float, phase: float, q_ref: float | None = None, seconds: float = 10.0) -> Conditioned:
    t = np.arange(round(seconds / 0.005)) * 0.005
    q = (np.sin(2 * np.pi * hertz * t + phase) + 0.02 * np.sin(2 * np.pi * 3 * hertz * t))[:, None]
    run = Run("swung", t, q, np.cos(2 * np.pi * hertz * t)[:, None])
    run = run if q_ref is None else replace(run, q_ref=np.full_like(q, q_ref))
    return condition(TRUE, run, 15.0, np.full(1, 1e-6))


def test_a_motion_that_swings_has_a_rhythm_whatever_the_phases_of_its_runs() -> None:
    frequency, apart = rhythm([swung(HERTZ, phase) for phase in (0.0, 1.0, 4.0)], 0)
    assert abs(frequency - HERTZ) < 0.5 * apart
    assert apart == pytest.approx(0.1, rel=0.05)  # of 10 s


@pytest.mark.parametrize(
    ("hertz", "asked"),
    [(4.0, True), *(pytest.param(hertz, False, marks=pytest.mark.long) for hertz in (4.0, 2.0))],
)
def test_a_long_recording_swings_as_a_short_one_does(hertz: float, asked: bool) -> None:
    """Taken every so many samples it would seem to swing at another frequency."""
    run = swung(hertz, 0.3, seconds=400.0)
    run = replace(run, run=replace(run.run, q_ref=run.run.q)) if asked else run
    frequency, apart = rhythm([run], 0)
    assert abs(frequency - hertz) < 0.5 * apart


def test_runs_that_swing_each_at_its_own_frequency_and_other_motions_have_none() -> None:
    assert rhythm([swung(HERTZ, 0.0), swung(1.7 * HERTZ, 0.0)], 0) == (0.0, 0.0)
    assert rhythm([condition(TRUE, sines(10.0), 15.0, np.full(1, 1e-6))], 0) == (0.0, 0.0)


def test_an_arm_that_is_to_rest_and_is_shaken_has_none() -> None:
    """What it swings at is then the disturbance itself."""
    assert rhythm([swung(HERTZ, 0.0, q_ref=0.3)], 0) == (0.0, 0.0)


@pytest.mark.parametrize("law", ["one_wave", "harmonics"])
def test_a_wave_in_time_with_the_motion_is_not_taken_for_a_disturbance(law: str) -> None:
    effect = effect_named("input_disturbance", law)
    scale = replace(SCALE, rhythm=(HERTZ, 0.1))
    plausible = {f: effect.plausible({"frequency": f}, scale) for f in (0.8, 1.62, 2.4, 3.2, 8.05, 17.6)}
    alone = law == "one_wave"  # half the frequency has harmonics in time with it
    assert plausible == {0.8: alone, 1.62: False, 2.4: alone, 3.2: False, 8.05: False, 17.6: True}
    assert all(effect.plausible({"frequency": f}, SCALE) for f in plausible)
