"""Cases of one's own arm and motions: the laboratory is read off the recordings, the motions are tracked anew."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import stribeck
from stribeck.arm import EffectEntry, load_arm
from stribeck.errors import InputError, StribeckError
from stribeck.run import Run, load_run
from stribeck.withheld.bench import Bench
from stribeck.withheld.injections import Injection
from stribeck.withheld.own import own_maker, possible
from stribeck.withheld.plan import Plan
from stribeck.withheld.recorder import default_gains
from stribeck.withheld.strength import strengths

EXAMPLE = Path(stribeck.__file__).parent / "example"


def first(run: Run, seconds: float) -> Run:
    rows = run.t <= seconds
    return replace(run, t=run.t[rows], q=run.q[rows], tau=run.tau[rows])


@pytest.fixture(scope="module")
def arm():
    return load_arm(EXAMPLE / "arm.toml")


@pytest.fixture(scope="module")
def runs():
    return [first(load_run(EXAMPLE / f"run_0{i}.csv", 2), 3.0) for i in (1, 2)]


def test_the_laboratory_is_read_off_the_recordings(arm, runs):
    """The example was recorded at 500 Hz with counts of 6e-6 rad and noise of 1e-5 rad."""
    maker = own_maker(arm, runs)
    assert maker.bench.rate == 500.0
    assert maker.bench.noise == pytest.approx(1e-5, rel=0.15)
    assert maker.resolution == (6e-6, 6e-6)
    unstated = replace(arm, joints=tuple(replace(j, encoder_resolution=None) for j in arm.joints))
    assert own_maker(unstated, runs).resolution == pytest.approx((6e-6, 6e-6), rel=1e-2)


def test_smooth_angles_have_no_count(arm):
    t = 0.002 * np.arange(600)
    smooth = Run("smooth", t, np.sin(3.0 * t)[:, None] * [1.0, 0.5], np.zeros((600, 2)))
    unstated = replace(arm, joints=tuple(replace(j, encoder_resolution=None) for j in arm.joints))
    maker = own_maker(unstated, [smooth])
    assert maker.resolution == (0.0, 0.0)
    assert maker.bench.noise < 1e-9


def test_the_recorded_motion_is_tracked_from_rest(arm, runs):
    case = own_maker(arm, runs)(3, Plan("none"))
    assert case.arm_nominal == arm
    assert case.arm_true != arm
    for made, given in zip(case.runs, runs, strict=True):
        lead = len(made.t) - len(given.t)
        off = made.q[lead:] - given.q[: len(made.q) - lead]
        assert np.abs(off).max() < 0.15 * np.ptp(given.q, axis=0).max()
        assert np.abs(np.diff(made.q[:10], axis=0)).max() < 1e-4  # at rest first
    assert case.truth["effects"] == []


def test_a_reference_comes_before_the_recorded_motion(arm, runs):
    still = replace(runs[0], q_ref=np.zeros_like(runs[0].q))
    (run,) = own_maker(arm, [still])(3, Plan("none")).runs
    assert np.abs(run.q).max() < 1e-2
    assert run.q_ref is not None


@pytest.mark.long
def test_an_effect_is_hidden_in_the_arm(arm, runs):
    case = own_maker(arm, runs)(3, Plan("single", ("delay",), "clear"))
    (hidden,) = case.truth["effects"]
    assert hidden["effect"] == "delay"
    assert hidden["strength"] > 1.0


def test_what_cannot_be_hidden_is_said(arm, runs):
    assert "negative_damping" not in possible(arm)
    with pytest.raises(StribeckError, match="negative_damping is no news to this arm"):
        own_maker(arm, runs)(3, Plan("single", ("negative_damping",), "clear"))
    with pytest.raises(InputError, match="an arm with effects of its own cannot be recorded: found delay"):
        own_maker(replace(arm, effects=(EffectEntry("delay", ("A",)),)), runs)


def test_a_motion_of_a_moment_is_refused(arm, runs):
    with pytest.raises(InputError, match=r"run_01.csv: too short to track: found 0\.5 s"):
        own_maker(arm, [first(runs[0], 0.5)])


@pytest.fixture(scope="module")
def stand(arm, runs):
    maker = own_maker(arm, runs)
    case = maker(3, Plan("none"))
    return case.arm_true, arm, maker.programme(), maker.bench


def test_strength_grows_with_the_effect_and_falls_with_the_noise(stand):
    true, nominal, motions, bench = stand
    weak, strong = strengths(
        true, nominal, [Injection("torque_offset", "A", {"offset": x}) for x in (1.0, 4.0)], motions, bench
    )
    assert strong.plain == pytest.approx(4.0 * weak.plain, rel=0.3)  # a torque is worth itself
    noisy = replace(bench, noise=1e-3)
    (less,) = strengths(true, nominal, [Injection("torque_offset", "A", {"offset": 4.0})], motions, noisy)
    assert less.plain < 0.5 * strong.plain


def test_an_effect_at_its_null_has_no_strength(stand):
    true, nominal, motions, bench = stand
    (nothing,) = strengths(true, nominal, [Injection("delay", "A", {"time": 0.0})], motions, bench)
    assert nothing == (0.0, 0.0)


def test_a_bench_gives_its_controller_the_gains_it_says():
    arm = load_arm(EXAMPLE / "arm.toml")
    bench = Bench(500.0, 16, 0.0, 2.0, 0.7, 0.1, "none", 0.004, 8.0, (), False, ())
    assert bench.gains(arm) == replace(default_gains(arm, 2.0, 0.7, 0.1, "none"), velocity_filter=0.004)
