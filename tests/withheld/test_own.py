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
    assert maker.bench.noise == pytest.approx((1e-5, 1e-5), rel=0.15)
    assert maker.resolution == (6e-6, 6e-6)
    unstated = replace(arm, joints=tuple(replace(j, encoder_resolution=None) for j in arm.joints))
    assert own_maker(unstated, runs).resolution == pytest.approx((6e-6, 6e-6), rel=1e-2)


def test_smooth_angles_have_no_count(arm):
    t = 0.002 * np.arange(600)
    smooth = Run("smooth", t, np.sin(3.0 * t)[:, None] * [1.0, 0.5], np.cos(t)[:, None] * [1.0, 0.5])
    unstated = replace(arm, joints=tuple(replace(j, encoder_resolution=None) for j in arm.joints))
    maker = own_maker(unstated, [smooth])
    assert maker.resolution == (0.0, 0.0)
    assert max(maker.bench.noise) < 1e-9


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


def turning(t, name="a.csv", noise=0.0):
    """One joint after another goes around, with noise on its encoder."""
    q = 2.0 * t[:, None] * [1.0, 0.5] + 0.3 * np.sin(3.0 * t)[:, None]
    q += noise * np.random.default_rng(0).standard_normal(q.shape)
    return Run(name, t, q, np.cos(t)[:, None] * [1.0, 0.5])


def fastest(maker):
    return max(float(np.abs(motion.sample(np.arange(0.0, motion.duration, 0.005))[1]).max()) for motion in maker)


def test_a_counter_that_begins_anew_and_a_wrong_reading_are_no_motion(arm):
    run = turning(0.004 * np.arange(1500))
    wrapped, wrong = (run.q + np.pi) % (2.0 * np.pi) - np.pi, run.q.copy()
    wrong[700, 0] += 1.0
    asked = fastest(own_maker(arm, [run]).programme())
    for q, says in ((wrapped, "as of a counter that begins anew"), (wrong, "positions that leap and are back")):
        maker = own_maker(arm, [replace(run, q=q)])
        assert fastest(maker.programme()) == pytest.approx(asked, rel=1e-2)
        (note,) = maker.notes
        assert says in note


def test_recordings_begin_in_the_same_turn(arm):
    run = turning(0.004 * np.arange(1500))
    wrapped = (run.q + np.pi) % (2.0 * np.pi) - np.pi
    later = replace(run, name="b.csv", q=wrapped + 2.0 * np.pi)
    maker = own_maker(arm, [replace(run, q=wrapped), later])
    first, second = (motion.sample(np.array([2.0]))[0] for motion in maker.programme())
    assert first == pytest.approx(second, abs=1e-3)
    assert any("moved by whole turns" in note for note in maker.notes)


def test_each_encoder_has_its_own_noise_beside_a_fast_motion(arm):
    t = 0.02 * np.arange(400)
    phase = 2.0 * np.pi * np.cumsum(0.3 * (5.0 / 0.3) ** (t / 8.0)) * 0.02
    noise = np.random.default_rng(0).standard_normal((400, 2)) * [5e-6, 1e-3]
    run = Run("a.csv", t, 0.15 * np.sin(phase)[:, None] + noise, np.cos(t)[:, None] * [1.0, 0.5])
    unstated = replace(arm, joints=tuple(replace(j, encoder_resolution=None) for j in arm.joints))
    assert own_maker(unstated, [run]).bench.noise == pytest.approx((5e-6, 1e-3), rel=0.25)


def test_the_rate_is_that_of_most_of_the_time(arm):
    runs = [turning(np.arange(0.0, 4.0, 0.001), "a.csv"), turning(np.arange(0.0, 9.0, 0.01), "b.csv")]
    maker = own_maker(arm, runs)
    assert maker.bench.rate == 100.0
    assert maker.notes == ("recorded at 100 Hz, as most of the time was; at another rate: a.csv",)


def test_what_is_not_tracked_is_said(arm):
    maker = own_maker(arm, [turning(np.arange(0.0, 70.0, 0.01))])
    assert maker.notes == ("a.csv: its first 60 s are tracked, of 69.99",)
    assert maker.bench.duration == 60.0


def braked(run, k):
    """The recording with a brake on one joint."""
    q, tau = run.q.copy(), run.tau.copy()
    q[:, k], tau[:, k] = q[0, k], 0.0
    return replace(run, q=q, tau=tau)


def test_a_braked_joint_stays_held_and_hides_nothing(arm, runs):
    maker = own_maker(arm, [braked(first(runs[0], 1.5), 1)])
    assert maker.driven == ("A",)
    assert maker.notes == ("held in all recordings, at a constant torque: nothing is hidden in B",)
    assert "payload" not in maker.effects()
    assert "torque_offset" in maker.effects()
    case = maker(3, Plan("none", disturbed=True))
    assert case.truth["disturbances"][0]["joint"] == "A"
    assert case.truth["worth"]["B"] == 0.0
    for run in case.runs:
        assert np.ptp(run.q[:, 1]) < 10.0 * max(maker.bench.noise[1], maker.resolution[1])
        assert not run.tau[:, 1].any()
        assert run.tau[:, 0].any()
    with pytest.raises(InputError, match="payload needs joint B driven: found held in all recordings"):
        maker.effects(["delay", "payload"])


@pytest.mark.long
def test_where_one_drive_works_at_a_time_an_effect_is_sized_where_its_own_does(arm, runs):
    maker = own_maker(arm, [braked(first(run, 1.5), k) for k, run in enumerate(runs)])
    assert [motion.held for motion in maker.programme()] == [(0,), (1,)]
    assert maker.driven == ("A", "B")
    case = maker(3, Plan("single", ("torque_offset",), "clear"))
    (hidden,) = case.truth["effects"]
    assert case.truth["worth"][hidden["joint"]] > 0.05
    assert hidden["strength"] > 1.0


def test_a_joint_that_swings_is_refused(arm, runs):
    tau = runs[0].tau * [1.0, 0.0]
    says = "run_01.csv: joint B moves, but its torque is zero all along; give what was commanded as tau2; a joint"
    with pytest.raises(InputError, match=says):
        own_maker(arm, [replace(runs[0], tau=tau)])
    with pytest.raises(InputError, match="no joint is driven in any recording: found run_01"):
        own_maker(arm, [braked(braked(runs[0], 0), 1)])


def test_a_filter_of_a_velocity_that_is_not_recorded_is_not_hidden(arm, runs):
    bare, told = own_maker(arm, runs), own_maker(arm, [replace(run, dq=np.gradient(run.q, axis=0)) for run in runs])
    assert "velocity_filter" not in bare.effects()
    assert "velocity_filter" in told.effects()
    assert told.effects(["velocity_filter"]) == ("velocity_filter",)
    with pytest.raises(InputError, match="velocity_filter needs dq1, dq2 in the recordings"):
        bare.effects(["velocity_filter"])


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
