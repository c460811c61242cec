"""Prediction in windows: near the truth where the model is true, and a status where it runs away."""

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stribeck.arm import Arm, EffectEntry, Friction, load_arm, save_arm
from stribeck.cli import main
from stribeck.errors import InputError
from stribeck.grid import uniform
from stribeck.identify.conditioning import condition
from stribeck.identify.cutoff import cutoff_frequency
from stribeck.identify.noise import encoder_noise
from stribeck.identify.residual import Residual
from stribeck.run import Run, load_run, save_run
from stribeck.simulate import Compensation, Engine, JointLoop, Loop, Reference, predict, simulate_loop

from .conftest import entry, two_links

STEP = 0.005
SLOW = pytest.mark.slow
REAL = Path(__file__).parents[3] / "shared" / "data" / "dfki-double-pendulum"


def recorded(arm: Arm, noise: float = 1e-5) -> Run:
    """A closed-loop recording with reversals, sticking and sliding, positions only."""
    sines = [Reference("sine", amplitude=a, frequency=f) for a, f in ((0.8, 0.31), (0.6, 0.53))]
    joints = tuple(
        JointLoop(name, kp, sine, encoder_noise=noise, compensation=Compensation("feedforward"))
        for name, kp, sine in zip(arm.names, (120.0, 50.0), sines, strict=True)
    )
    return replace(simulate_loop(arm, Loop(STEP, 12.0, joints)).run("made.csv"), q_ref=None, dq_ref=None)


def rms(values: np.ndarray) -> np.ndarray:
    return np.asarray(np.sqrt(np.mean(values**2, axis=0)))


@pytest.mark.parametrize(
    "effects",
    [
        (),
        (entry("actuator_lag", ("A", "B"), time_constant=0.02), entry("delay", ("A",), time=0.013)),
        pytest.param((entry("presliding", ("A",), stiffness=800.0, damping=4.0),), marks=SLOW),
        pytest.param((entry("joint_flexibility", ("B",), stiffness=300.0, damping=0.6),), marks=SLOW),
        pytest.param((entry("encoder_eccentricity", ("A",), sine=0.05, cosine=0.0),), marks=SLOW),
        (entry("backlash", ("B",), gap=0.01, stiffness=600.0, damping=3.0),),
    ],
    ids=lambda effects: "+".join(effect.effect for effect in effects) or "none",
)
def test_true_model_predicts(effects: tuple[EffectEntry, ...]) -> None:
    arm = two_links(*effects, gravity=(9.81, 0.0))
    run = recorded(arm)
    found = predict(arm, run, 0.5)
    assert found.failed == ()
    later = found.window > 0  # what went on before a recording began, nobody knows
    error = rms((found.q - run.q)[later])
    assert (error < 0.005).all()
    joints = tuple(replace(j, friction=_more(j.friction), backward=_more(j.friction)) for j in arm.joints)
    assert (rms((predict(replace(arm, joints=joints), run, 0.5).q - run.q)[later]) > 3 * error).all()
    inside = slice(100, -100)
    assert (rms((found.tau - run.tau)[inside]) < 0.35 * rms(run.tau)).all()


def _more(friction: Friction) -> Friction:
    return replace(friction, C0=friction.C0 + 2.0)


@pytest.mark.parametrize("time", [0.0123, -0.0123])
def test_one_joint_whose_record_is_late_is_predicted_as_the_others_move_it(time: float) -> None:
    """The other joint's torque comes when it comes: a command that is late instead is not the same."""
    arm = two_links()
    run = recorded(arm, noise=0.0)
    seen = np.interp(run.t - time, run.t, run.q[:, 1])
    late = replace(run, q=np.column_stack([run.q[:, 0], seen]))
    plain, shifted = (predict(a, late, 0.5) for a in (arm, two_links(entry("time_shift", ("B",), time=time))))
    inside = (plain.window > 0) & (plain.window < plain.window[-1])
    error, own = (rms((found.q - late.q)[inside]) for found in (shifted, predict(arm, run, 0.5)))
    assert (error < 0.1 * rms((plain.q - late.q)[inside])).all()
    assert (error < 1.2 * own + 1e-4).all()


@pytest.mark.parametrize("noise", [0.0, 1e-5])
@pytest.mark.parametrize("begins", [0.0, 0.5])
def test_torque_is_right_to_the_ends_and_where_it_steps(joint_a: Engine, begins: float, noise: float) -> None:
    """A joint at rest takes a step of 8 N m, with the first row or later: the torque that it needs is the command."""
    t = 0.002 * np.arange(1001)
    tau = np.where(t >= begins, 8.0 + 2.0 * np.sin(4.0 * t), 0.0)[:, None]
    q = joint_a.run(joint_a.p, joint_a.start(joint_a.p, np.zeros(1)), t, tau).q
    run = Run("step.csv", t, q + noise * np.random.default_rng(1).normal(size=q.shape), tau)
    arm = joint_a.path.arm
    assert np.abs(predict(arm, run, 0.5).tau - tau).max() < 0.3
    low = replace(arm.joints[0].friction, C0=3.0)
    lacking = predict(replace(arm, joints=(replace(arm.joints[0], friction=low, backward=low),)), run, 0.5)
    slides = t >= begins + 0.1 if begins else t >= 0.0
    assert np.abs((lacking.tau - tau)[slides] + 2.0).max() < 0.3


def test_torque_departs_by_as_much_as_a_diagnosis_tells(level_arm: Engine) -> None:
    """Commands that step while joints rest: how much friction takes there depends on the filters."""
    t = 0.001 * np.arange(4001)
    tau = np.column_stack([6.0 * np.sign(np.sin(7.0 * t)), 4.0 * np.sign(np.sin(5.0 * t + 1.0))])
    q = level_arm.run(level_arm.p, level_arm.start(level_arm.p, np.zeros(2)), t, tau).q
    arm, run = two_links(), Run("steps.csv", t, q + 1e-4 * np.random.default_rng(1).normal(size=q.shape), tau)
    noise = encoder_noise(arm, [run])
    cutoff = cutoff_frequency(arm, [run], level_arm.moved_inertia(np.median(run.q, axis=0)), noise)
    analysed = condition(arm, run, cutoff, noise, thin=True)
    assert len(analysed.time) < 0.2 * len(t)
    told = Residual(level_arm.path, [analysed], ()).value(level_arm.p)
    assert rms(predict(arm, run, 0.5).tau - tau) == pytest.approx(rms(told), rel=0.05)


def test_windows_start_on_the_record() -> None:
    arm = two_links()
    run = recorded(arm)
    found = predict(arm, run, 0.25)
    starts = np.flatnonzero(np.diff(found.window, prepend=-1))
    assert np.diff(starts).tolist() == [50] * (len(starts) - 1)
    assert np.abs(found.q[starts] - run.q[starts]).max() < 2e-3
    assert len(found.t) == len(run.t)
    assert len(found.status) == len(starts)
    since_1970 = 1764201234.5
    later = predict(arm, replace(run, t=run.t + since_1970), 0.25)
    np.testing.assert_allclose(later.t - since_1970, run.t, atol=1e-6)
    np.testing.assert_allclose(later.q, found.q, atol=1e-4)


def test_what_was_done_to_the_recording_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    save_arm(two_links(), "arm.toml")
    run = recorded(two_links())
    save_run(run, "as_it_is.csv")
    late = replace(run, t=run.t + 0.3 * STEP * np.sin(np.arange(len(run.t)) ** 2), dq=None)
    save_run(replace(late, q=(run.q + 3.0 + np.pi) % (2.0 * np.pi) - np.pi), "as_it_comes.csv")
    for name, told in (("as_it_is", ()), ("as_it_comes", ("begins anew: q1 (", "ms apart, which makes"))):
        assert main(["predict", "arm.toml", f"{name}.csv", "--horizon", "0.5", "--out", f"{name}_ahead.csv"]) == 0
        *lines, written, errors = capsys.readouterr().out.splitlines()
        assert written == f"{name}_ahead.csv: 25 windows of up to 0.5 s"
        assert re.fullmatch(r"rms error: motion \S+ rad at A, .+ at B, torque \S+ N m at A, .+ at B", errors)
        for line, text in zip(lines, told, strict=True):
            assert line.startswith(f"note: {name}.csv: ")
            assert text in line


def test_errors_and_doubts_are_told() -> None:
    arm = two_links()
    run = recorded(arm)
    found = predict(arm, run, 0.5)
    assert found.warnings == ()
    np.testing.assert_allclose(found.motion_error, rms(found.q - run.q))
    np.testing.assert_allclose(found.torque_error, rms(found.tau - run.tau))
    limited = replace(arm, joints=tuple(replace(joint, torque_limit=100.0, mass=4e3) for joint in arm.joints))
    wrong = predict(limited, replace(run, tau=-1e3 * run.tau, warnings=("q1 is odd",)), 100.0).warnings
    for text in (
        "A: the arm file's mass is 4000 kg",
        "made.csv: q1 is odd",
        "beyond its torque_limit of 100 N m",
        "lasts 12 s, less than the horizon of 100 s",
    ):
        assert any(text in said for said in wrong)
    signs = predict(arm, replace(run, tau=-run.tau), 0.5).warnings
    assert any("check the signs of its torque and position" in said for said in signs)


def test_a_window_of_two_samples_is_one_whatever_the_clock() -> None:
    run = recorded(two_links())
    t = 10.0 + 0.0005 * np.arange(400)  # the first two differ by a little more than half a millisecond
    assert t[1] - t[0] > 0.0005
    assert predict(two_links(), replace(run, t=t, q=run.q[:400], tau=run.tau[:400]), 0.001).window[-1] == 199


def test_runaway_windows_are_held_and_named() -> None:
    arm = two_links()
    run = recorded(arm)
    torn = replace(run, tau=run.tau * 1e7)
    found = predict(arm, torn, 1.0)
    assert len(found.failed) > 0
    assert {found.status[i] for i in found.failed} <= {"unbounded", "too_many_steps", "step_too_small"}
    for values in (found.q, found.dq, found.tau):
        assert np.isfinite(values).all()


def test_refuses() -> None:
    arm = two_links()
    run = recorded(arm)
    with pytest.raises(InputError, match="horizon"):
        predict(arm, run, 0.001)
    alone = replace(run, q=run.q[:, :1], tau=run.tau[:, :1], dq=None)
    with pytest.raises(InputError, match="not a recording of this arm"):
        predict(arm, alone, 0.5)
    with pytest.raises(InputError, match="horizon"):
        predict(arm, run, math.nan)


@pytest.mark.skipif(not REAL.exists(), reason="the recordings are not at hand")
@pytest.mark.parametrize("name", ["design-A.0/run_01.csv", pytest.param("design-C.1/run_04.csv", marks=SLOW)])
def test_real_recordings(name: str) -> None:
    arm = load_arm(REAL / name.split("/")[0] / "arm.toml")
    run = load_run(REAL / name, 2)
    for given in (run, replace(run, dq=None)):
        found = predict(arm, given, 0.3)
        even, _ = uniform(given)
        assert found.failed == ()
        for values in (found.q, found.dq, found.tau):
            assert np.isfinite(values).all()
        assert (rms(found.q - even.q) < (0.1, 0.35)).all()


def test_missing_samples_are_no_error_of_the_model() -> None:
    """What is drawn across them has the accelerations of a blow; the same model is as good beside them as without."""
    arm = two_links(gravity=(9.81, 0.0))
    run = recorded(arm)
    kept = np.delete(np.arange(len(run.t)), np.arange(1000, 1040))
    lossy = replace(run, t=run.t[kept], q=run.q[kept], tau=run.tau[kept], dq=None)
    whole, found = predict(arm, replace(run, dq=None), 0.5), predict(arm, lossy, 0.5)
    for error in ("torque_error", "motion_error"):
        assert np.all(getattr(found, error) < 1.5 * getattr(whole, error)), error
    (text,) = [text for text in found.warnings if "missing samples" in text]
    assert "1 of 25 windows lie across" in text
    assert not any("missing samples" in text for text in whole.warnings)
