"""Closed loops against what is known: ramp errors, limit cycles in closed form, thresholds, remedies."""

import math
from dataclasses import replace

import numpy as np
import pytest

from stribeck.arm import EffectEntry, Friction
from stribeck.simulate import (
    Closed,
    Compensation,
    Engine,
    JointLoop,
    Loop,
    Reference,
    close_loop,
    path_of,
    simulate_many,
)

from .conftest import one_joint

RATE = 0.0125


def run(
    engine: Engine,
    reference: Reference,
    compensation: Compensation | None = None,
    *,
    sample_time: float = 0.0,
    duration: float = 60.0,
    kp: float = 30.0,
    tolerance: float = 1e-8,
    seed: int = 0,
    **settings: float,
) -> Closed:
    entry = JointLoop("A", kp, reference, compensation=compensation or Compensation(), **settings)  # type: ignore[arg-type]
    loop = Loop(sample_time, duration, (entry,), record_step=0.005, seed=seed)
    return close_loop(engine, loop, tolerance=tolerance)


def second_half(values: np.ndarray) -> np.ndarray:
    return values[len(values) // 2 :]


def cycle(found: Closed) -> tuple[float, float]:
    """Half the peak-to-peak position in the last quarter, and the period between forward starts."""
    q = found.motion.q[3 * len(found.motion.q) // 4 :, 0]
    events = found.motion.events
    starts = events["time"][events["after"] == 1.0]
    return 0.5 * float(np.ptp(q)), float(np.diff(starts[-6:]).mean()) if len(starts) > 6 else math.nan


@pytest.mark.parametrize("sample_time", [RATE, 0.0])
@pytest.mark.parametrize(
    ("joint", "kp", "velocity", "error"),
    [
        ("joint_a", 30.0, 0.5, 191.7), ("joint_a", 30.0, 0.05, 184.5), ("joint_a", 60.0, 0.5, 95.8),
        ("joint_a", 60.0, 0.05, 92.3), ("joint_b", 30.0, 0.5, 86.7), ("joint_b", 30.0, 0.05, 80.4),
        ("joint_b", 60.0, 0.5, 43.3), ("joint_b", 60.0, 0.05, 40.2),
    ],
)  # fmt: skip
def test_ramp_error(
    joint: str, kp: float, velocity: float, error: float, sample_time: float, request: pytest.FixtureRequest
) -> None:
    engine: Engine = request.getfixturevalue(joint)
    ramp = Reference("ramp", velocity=velocity)
    plain = run(engine, ramp, kp=kp, sample_time=sample_time)
    assert 1e3 * second_half(plain.error).mean() == pytest.approx(error, rel=5e-3)
    for ratio in (0.9, 1.0, 1.1):
        helped = run(engine, ramp, Compensation("feedforward", ratio), kp=kp, sample_time=sample_time)
        assert 1e3 * second_half(helped.error).mean() == pytest.approx((1 - ratio) * error, rel=5e-3, abs=1e-3)


@pytest.mark.parametrize("bristle", [False, True])
@pytest.mark.parametrize(("at_zero", "settings"), [("hold", {}), ("hold", {"velocity_filter": 0.02}), ("zero", {})])
def test_a_dead_band_holds_the_sign_with_which_it_was_entered(
    bristle: bool, at_zero: str, settings: dict[str, float]
) -> None:
    """A continuous controller is the limit of a sampled one, whose own memory holds the sign."""
    stiff = EffectEntry("presliding", ("A",), {"A": {"stiffness": 3000.0, "damping": 20.0}}, "lugre")
    arm = replace(one_joint(Friction(5.0, 0.0, 0.0, 0.05)), effects=(stiff,) if bristle else ())
    law = Compensation("feedback", 0.9, at_zero, dead_band=0.05)  # type: ignore[arg-type]
    sine = Reference("sine", amplitude=0.2, frequency=0.5)
    exact, sampled = (
        run(
            Engine(path_of(arm)),
            sine,
            law,
            kp=60.0,
            kv=3.0,
            sample_time=step,
            duration=4.0,
            velocity="true",
            **settings,
        )  # type: ignore[arg-type]
        for step in (0.0, 1e-4)
    )
    assert (exact.motion.status, sampled.motion.status) == ("ok", "ok")
    wide, narrow = (float(np.sqrt(np.mean(found.error**2))) for found in (exact, sampled))
    assert wide == pytest.approx(narrow, rel=5e-3)


@pytest.mark.parametrize("at_zero", ["set_valued", "error_sign"])
@pytest.mark.parametrize("zeta", [0.1, 0.5, 0.9])
@pytest.mark.parametrize("ratio", [1.1, 1.3])
def test_coth_law(coulomb: Engine, ratio: float, zeta: float, at_zero: str) -> None:
    """Over-compensation of Coulomb friction on measured velocity: amplitude and period in closed form."""
    kp, c0 = 30.0, 5.0
    compensation = Compensation("feedback", ratio, at_zero)  # type: ignore[arg-type]
    found = run(coulomb, Reference("regulate", initial_error=0.5), compensation, kv=2 * zeta * math.sqrt(kp))
    root = math.sqrt(1 - zeta**2)
    amplitude, period = cycle(found)
    assert amplitude == pytest.approx((ratio - 1) * c0 / kp / math.tanh(math.pi * zeta / (2 * root)), rel=1e-3)
    assert period == pytest.approx(2 * math.pi / (math.sqrt(kp) * root), rel=1e-3)


@pytest.mark.parametrize(
    ("at_zero", "below", "above"),
    [("zero", 0.97, 1.03), ("hold", 0.97, 1.03), ("set_valued", 0.97, 1.03)],
)
def test_critical_ratio(coulomb: Engine, at_zero: str, below: float, above: float) -> None:
    """The ratio over which compensation cycles depends on what it does at velocity zero."""
    zeta, kp = 0.2, 30.0
    rho = math.exp(-math.pi * zeta / math.sqrt(1 - zeta**2))
    critical = {"zero": 2 / (1 + rho), "hold": 1 / rho, "set_valued": 1.0}[at_zero]
    for share, cycles in ((below, False), (above, True)):
        compensation = Compensation("feedback", critical * share, at_zero)  # type: ignore[arg-type]
        found = run(
            coulomb, Reference("regulate", initial_error=3.0), compensation, kv=2 * zeta * math.sqrt(kp), duration=300.0
        )
        assert (cycle(found)[0] > 1e-4) == cycles


def test_critically_damped_rests(coulomb: Engine) -> None:
    """At zeta = 1 there is no cycle: rest at (k - 1) Fs/Kp."""
    found = run(coulomb, Reference("regulate", initial_error=0.5), Compensation("feedback", 1.3, "hold"))
    assert np.ptp(second_half(found.motion.q[:, 0])) == 0.0


def test_known_cycles(joint_a: Engine) -> None:
    regulate = Reference("regulate", initial_error=0.5)
    over = run(joint_a, regulate, Compensation("feedback", 1.3, "set_valued"), kv=math.sqrt(30.0))
    assert cycle(over) == pytest.approx((0.0757, 1.345), rel=2e-3)
    hunting = run(joint_a, regulate, Compensation("feedback", 0.9), ki=30.0, duration=200.0)
    assert cycle(hunting)[0] == pytest.approx(0.091, rel=0.01)
    noise = {"sample_time": RATE, "encoder_noise": 2e-5, "duration": 200.0}
    noisy = run(joint_a, regulate, Compensation("feedback", 1.3), **noise)
    assert cycle(noisy)[0] == pytest.approx(0.0609, rel=0.03)
    band = 5.0 * math.sqrt(2.0) * 2e-5 / RATE
    assert cycle(run(joint_a, regulate, Compensation("feedback", 1.3, dead_band=band), **noise))[0] == 0.0


@pytest.mark.parametrize(("velocity", "sticks"), [(0.008, True), (0.012, False)])
def test_feedforward_leaves_the_stick_slip_threshold(joint_b: Engine, velocity: float, sticks: bool) -> None:
    """Feedforward shifts the error and nothing else: the same sticking for every ratio."""
    shares = []
    for ratio in (0.0, 0.5, 1.0, 1.3):
        found = run(joint_b, Reference("ramp", velocity=velocity), Compensation("feedforward", ratio), duration=300.0)
        stuck = second_half(found.motion.stuck_time[:, 0])
        shares.append((stuck[-1] - stuck[0]) / 150.0)
    assert (np.array(shares) > 0.05).all() if sticks else (np.array(shares) == 0.0).all()
    assert np.ptp(shares) < 0.01


def test_stability_limits(joint_a: Engine) -> None:
    regulate = Reference("regulate", initial_error=0.1)
    stable = run(joint_a, regulate, kp=3100.0, sample_time=RATE)
    assert stable.motion.ok
    lost = run(joint_a, regulate, kp=3400.0, sample_time=RATE)
    assert lost.motion.status == "unbounded"
    assert 0.0 < lost.ended < 60.0
    assert np.isfinite(lost.motion.q[: lost.motion.filled]).all()
    growing = run(joint_a, regulate, Compensation("feedback", 9.0, "set_valued"))
    assert growing.motion.status == "unbounded"


@pytest.mark.parametrize("ratio", [1.1, 3.0])
def test_a_continuous_robust_law_brings_a_joint_to_rest(joint_a: Engine, ratio: float) -> None:
    """It overshoots ever less in ever less time, until its jump at zero error holds the joint."""
    found = run(joint_a, Reference("regulate", initial_error=0.3), Compensation("robust", ratio), duration=5.0)
    assert found.motion.ok
    assert abs(found.error[-1, 0]) < 1e-9
    assert found.motion.modes[-1, 0] == 0.0


def test_remedies(joint_a: Engine) -> None:
    regulate = Reference("regulate", initial_error=0.1)
    robust = {"sample_time": 2e-4, "duration": 10.0}
    assert abs(run(joint_a, regulate, Compensation("robust", 1.05), **robust).error[-1, 0]) < 1e-6
    assert abs(run(joint_a, regulate, Compensation("robust", 0.9), **robust).error[-1, 0]) > 0.05
    sine = Reference("sine", amplitude=0.5, frequency=0.2)
    for ratio in (0.7, 1.3):
        rms = []
        for gain in ((0.0, 0.0, 0.0), (100.0, 100.0, 10.0)):
            adaptive = Compensation("adaptive", ratio, "set_valued", gain=gain)
            found = run(joint_a, sine, adaptive, inertia=1.0)
            rms.append(float(np.sqrt(np.mean(second_half(found.error) ** 2))))
        assert rms[0] > 0.04
        assert rms[1] < 0.003


@pytest.mark.parametrize("sample_time", [RATE, 0.0])
def test_steps_begin_at_their_own_instants(joint_a: Engine, sample_time: float) -> None:
    steps = Reference("steps", times=(1.0, 2.0), values=(0.1, 0.2))
    found = run(joint_a, steps, sample_time=sample_time, duration=3.0, kp=300.0, start=0.05)
    t, wanted = found.motion.t, found.reference[:, 0]
    assert (wanted == np.select([t < 1.0, t < 2.0], [0.05, 0.1], 0.2)).all()
    assert (found.motion.q[t < 1.0] == 0.05).all()
    assert found.motion.events["time"][0] == pytest.approx(1.0, abs=1e-9)


def test_delay_lag_and_filter_act(joint_a: Engine) -> None:
    step = Reference("steps", times=(0.0, 0.5), values=(0.0, 0.5))
    plain = run(joint_a, step, sample_time=RATE, duration=2.0, kv=11.0)
    late = run(joint_a, step, sample_time=RATE, duration=2.0, kv=11.0, delay_samples=3)
    first = [int(np.flatnonzero(found.command[:, 0])[0]) for found in (plain, late)]
    assert first == [40, 43]
    assert late.command[43, 0] == plain.command[40, 0]
    lagged = run(joint_a, step, sample_time=RATE, duration=2.0, kv=11.0, actuator_lag=0.05)

    broke = lagged.motion.events["time"][0] - 0.5
    assert broke == pytest.approx(-0.05 * math.log1p(-6.25 / 15.0), abs=1e-9)
    smooth = run(joint_a, step, sample_time=RATE, duration=2.0, kv=11.0, velocity_filter=0.05)
    assert not np.allclose(smooth.command, plain.command)


def test_the_command_is_told_as_computed_whatever_a_lag_makes_of_it(joint_a: Engine) -> None:
    """Of a continuous controller as of a sampled one: a diagnosis of the run could not see the lag otherwise."""
    step = Reference("regulate", initial_error=0.5)
    settings = {"duration": 1.0, "kv": 6.0, "actuator_lag": 0.2}
    smooth = run(joint_a, step, **settings)
    sampled = run(joint_a, step, sample_time=5e-4, **settings)
    at = np.array([0.1, 0.3, 0.7])
    commands = [np.interp(at, found.motion.t, found.command[:, 0]) for found in (smooth, sampled)]
    assert commands[0] == pytest.approx(commands[1], rel=0.02, abs=0.1)
    assert smooth.command[0, 0] == pytest.approx(30.0 * 0.5)


def test_encoder(joint_a: Engine) -> None:
    sine = Reference("sine", amplitude=0.5, frequency=0.5)
    coarse = run(joint_a, sine, sample_time=RATE, duration=5.0, encoder_resolution=1e-3)
    steps = coarse.measured / 1e-3
    assert np.abs(steps - np.round(steps)).max() < 1e-9
    assert np.abs(coarse.measured - coarse.motion.q).max() <= 0.5e-3 * (1 + 1e-9)
    first, again, other = (
        run(joint_a, sine, sample_time=RATE, duration=5.0, encoder_noise=1e-4, seed=seed) for seed in (1, 1, 2)
    )
    assert (first.measured == again.measured).all()
    assert (first.measured != other.measured).any()
    assert np.std(first.measured - first.motion.q) == pytest.approx(1e-4, rel=0.15)


def test_clamped_joint_stays(level_arm: Engine) -> None:
    entry = JointLoop("B", 30.0, Reference("sine", amplitude=0.8, frequency=1.0))
    found = close_loop(level_arm, Loop(RATE, 10.0, (entry,), clamp={"A": 0.3}))
    assert (found.motion.q[:, 0] == 0.3).all()
    assert (found.motion.dq[:, 0] == 0.0).all()
    assert np.ptp(found.motion.q[:, 1]) > 1.0


def test_follows_a_run(level_arm: Engine) -> None:
    """A followed curve is smooth between its knots; a joint held by its own PID stays near its place."""
    times = np.linspace(0.0, 10.0, 101)
    curve = Reference("file", times=tuple(times.tolist()), values=tuple((0.4 * np.sin(times)).tolist()), file="run.csv")
    held = JointLoop("B", 300.0, Reference("regulate"), ki=200.0)
    entry = JointLoop("A", 500.0, curve, compensation=Compensation("feedforward"))
    found = close_loop(level_arm, Loop(0.0, 10.0, (entry, held), record_step=0.01))
    assert np.abs(found.reference[:, 0] - 0.4 * np.sin(found.motion.t)).max() < 1e-3
    assert np.abs(found.error[:, 0]).max() < 0.05
    assert np.abs(found.motion.q[:, 1]).max() < 0.02


def test_batch_equals_single_runs(joint_a: Engine) -> None:
    loops = [
        Loop(RATE, 5.0, (JointLoop("A", kp, Reference("ramp", velocity=0.05), encoder_noise=1e-5),), seed=i)
        for i, kp in enumerate((20.0, 30.0, 60.0))
    ]
    for loop, found in zip(loops, simulate_many(joint_a, loops, jobs=2), strict=True):
        assert (found.measured == close_loop(joint_a, loop).measured).all()


@pytest.mark.parametrize("sample_time", [0.005, 0.0])
def test_a_run_followed_anew_moves_alike(joint_a: Engine, sample_time: float) -> None:
    """The reference velocity is the curve's at every knot, the ends too; behind its end the reference stands."""
    sine, law = Reference("sine", amplitude=0.3, frequency=0.4, phase=0.3), Compensation("feedforward")
    first = run(joint_a, sine, law, sample_time=sample_time, duration=3.0, kp=100.0)
    times, values = (tuple(rows.tolist()) for rows in (first.motion.t, first.reference[:, 0]))
    curve = Reference("file", times=times, values=values)
    again = run(joint_a, curve, law, sample_time=sample_time, duration=4.0, kp=100.0)
    kept = len(first.motion.t)
    assert again.reference_rate[:kept] == pytest.approx(first.reference_rate, abs=1e-4)
    assert again.motion.q[:kept] == pytest.approx(first.motion.q, abs=1e-5)
    assert (again.reference_rate[kept:] == 0.0).all()
    assert (again.reference[kept:] == first.reference[-1]).all()
