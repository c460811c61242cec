"""Random torque: what knows nothing of the motion is noise, and nothing that a law leaves passes for it."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.gap.diagnose import diagnose
from stribeck.gap.model import Model, retune
from stribeck.gap.prepare import Prepared, prepare
from stribeck.gap.random_torque import random_torque
from stribeck.run import Run

from .conftest import NOMINAL, recorded

FLOOR = np.array([0.02])
NOISE = {"amplitude": 0.0, "frequency": 1.0, "phase": 0.0, "noise": 0.3, "bandwidth": 3.0}
LOUD = {**NOISE, "noise": 1.0}  # over what encoder noise leaves


def retuned(runs: list[Run], floor: np.ndarray = FLOOR) -> tuple[Prepared, Model]:
    prepared = prepare(NOMINAL, runs)
    return prepared, retune(prepared, floor)


def test_coloured_noise_in_the_torque_is_random() -> None:
    prepared, base = retuned(recorded(("input_disturbance", NOISE)))
    (found,) = random_torque(prepared, base, FLOOR)
    assert found.joint == NOMINAL.names[0]
    assert found.unit == "N m"
    assert found.rms == pytest.approx(NOISE["noise"], rel=0.3)  # the analysis filter takes a little of it
    assert 0.5 * NOISE["bandwidth"] < found.bandwidth < 2.0 * NOISE["bandwidth"]


def test_it_counts_as_noise_and_nothing_is_named() -> None:
    found = diagnose(NOMINAL, recorded(("input_disturbance", LOUD)), jobs=1)
    assert found.verdict == "no_gap"
    assert not found.named
    floor = next(stage.torque for stage in found.stages if stage.stage == "noise_floor")[NOMINAL.names[0]]
    assert floor > found.random[0].rms
    chance = {cause.effect: cause.probability for cause in found.causes}
    assert chance["none"] > chance["input_disturbance"] > 0.1
    assert sum(chance.values()) == pytest.approx(1.0)
    without = diagnose(NOMINAL, recorded(("input_disturbance", LOUD)), jobs=1, leave_out=("input_disturbance",))
    assert "input_disturbance" not in {cause.effect for cause in without.causes}


@pytest.mark.parametrize(
    ("effect", "values"),
    [
        ("presliding", {"stiffness": 60.0, "damping": 0.5}),
        ("backlash", {"gap": 0.02}),
        ("actuator_lag", {"time": 0.02}),
        ("cable_spring", {"stiffness": 3.0, "rest": 0.5}),
        ("cogging", {"amplitude": 0.5, "harmonic": 7.0, "phase": 0.3}),
    ],
)
def test_a_missing_law_is_not_random(effect: str, values: dict[str, float]) -> None:
    prepared, base = retuned(recorded((effect, values)))
    rms = np.sqrt(np.mean(np.concatenate([base.fit.residual, base.held]) ** 2))
    assert rms > 1.5 * FLOOR[0]
    assert random_torque(prepared, base, FLOOR) == ()


def test_nor_is_what_follows_the_motion_smoothly() -> None:
    """A law that is linear leaves a residual as steady and as normal as the motion is: other runs foretell it."""
    prepared, base = retuned(recorded())
    rng = np.random.default_rng(0)
    rows = [len(run.analysis_index) for run in (*prepared.fit, *prepared.held)]
    noise = np.concatenate([np.convolve(rng.normal(size=n + 7), np.hanning(8), "valid") for n in rows])[:, None]
    fitted = len(base.fit.residual)
    speeds = [run.velocity[run.analysis_index] for run in (*prepared.fit, *prepared.held)]
    speed = np.concatenate(speeds)
    for left, random in ((noise, True), (speed / speed.std() + 0.2 * noise / noise.std(), False)):
        other = replace(base, fit=replace(base.fit, residual=left[:fitted]), held=left[fitted:])
        assert bool(random_torque(prepared, other, FLOOR)) is random


def test_at_the_floor_there_is_nothing_to_tell() -> None:
    prepared, base = retuned(recorded())
    assert random_torque(prepared, base, 2.0 * base.rms()) == ()
