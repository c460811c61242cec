"""Shooting against long event-driven simulation by the closed-loop engine, over random loops of every kind."""

import math
from collections import Counter
from dataclasses import dataclass, replace

import numpy as np
import pytest

from stribeck.arm import EffectEntry, Friction
from stribeck.loop.exact.engine import RoundsEngine
from stribeck.loop.exact.settle import settle
from stribeck.loop.exact.shooting import shoot
from stribeck.simulate import Compensation, JointLoop, Loop, Reference, close_loop

FAMILIES = ("plain", "delay", "lag", "pid", "filter")
RULES = ("zero", "hold", "error_sign", "set_valued")
CLOSE = {"continuous": 1e-4, "sampled": 1e-3}
LONGEST, MOST_ROWS = 20_000.0, 400_000  # s and rows of a simulation


def draw(rng, loop_of):
    """Return random friction and a random loop: delay, lag, PID, filter, each rule, damping ratios 0.1 to 1."""
    bounds = ((2.0, 6.0), (0.0, 2.0), (0.0, 2.0), (0.03, 0.1))
    friction = Friction(*(float(rng.uniform(*pair)) for pair in bounds))
    kp, zeta = float(10 ** rng.uniform(1.0, 2.0)), float(rng.uniform(0.1, 1.0))
    family, rule = str(rng.choice(FAMILIES)), str(rng.choice(RULES))
    settings = {
        "plain": {},
        "delay": {"sample_time": 0.0125, "delay_samples": int(rng.integers(0, 3))},
        "lag": {"actuator_lag": float(rng.uniform(0.002, 0.03))},
        "pid": {"ki": 2.0 * zeta * kp**1.5 * float(rng.uniform(0.03, 0.4))},
        "filter": {"velocity_filter": float(rng.uniform(0.002, 0.03))},
    }[family]
    ratio = float(rng.uniform(0.6, 2.6)) if rng.random() < 0.85 else None
    return friction, loop_of(ratio, rule, kp=kp, zeta=zeta, error=float(rng.uniform(0.3, 2.0)), **settings)


def simulated(engine, loop: Loop, period: float | None, close: float) -> tuple[str, float, float]:
    """Return what a simulation of the engine ends in, with amplitude and period over its last fifth.

    It is simulated twice as long until the fifth before says the same to a fifth of ``close``: cycles may take hundreds
    of rounds to settle, and rounds that shrink take ever longer. Under an integral a stuck joint is waited for.
    """
    duration = 60.0 + 60.0 * period if period is not None else 150.0 if loop.joints[0].ki == 0.0 else LONGEST
    while True:
        step = max(0.005 if period is None else min(0.005 * max(period, 1.0), 0.05), duration / MOST_ROWS)
        found = close_loop(engine, replace(loop, duration=duration, record_step=step), tolerance=1e-9)
        if not found.motion.ok:
            return found.motion.status, math.nan, math.nan
        before, last = (measured(found.motion, share * duration, (share + 0.2) * duration) for share in (0.6, 0.8))
        if last[0] < 2e-5:
            return "rest", last[0], math.nan
        if np.allclose(before, last, rtol=0.2 * close, atol=0.0):
            return "cycle", *last
        if duration > LONGEST:
            return "not settled", *last
        duration *= 2.0


def measured(motion, begin: float, end: float) -> tuple[float, float]:
    """Return amplitude and period between two times; without a period where fewer than six rounds are seen."""
    rows = (motion.t > begin) & (motion.t <= end)
    q, v, t = motion.q[rows, 0], motion.dq[rows, 0], motion.t[rows]
    over = q - 0.5 * (q.max() + q.min())
    rises = np.flatnonzero((over[:-1] < 0.0) & (over[1:] >= 0.0))
    if len(rises) < 7:
        return 0.5 * float(np.ptp(q)), math.nan
    times = t[rises] - over[rises] * (t[rises + 1] - t[rises]) / (over[rises + 1] - over[rises])
    high, low = (side * np.maximum.reduceat(peaks(side * q, side * v, t), rises)[:-1] for side in (1.0, -1.0))
    return 0.5 * float(np.mean(high - low)), float(np.diff(times).mean())


def peaks(q: np.ndarray, v: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Return positions with, where the velocity falls through zero before the next row, the largest on the way."""
    out = q.copy()
    here = np.flatnonzero((v[1:-1] > 0.0) & (v[2:] < 0.0)) + 1
    slope = (v[here] - v[here - 1]) / (t[here] - t[here - 1])
    out[here[slope < 0.0]] -= 0.5 * v[here[slope < 0.0]] ** 2 / slope[slope < 0.0]
    return out


@dataclass(frozen=True)
class Compared:
    """One loop: the verdict, the error (relative, of amplitude or period) over what is allowed, what is wrong."""

    verdict: str
    error: float
    wrong: tuple[str, ...]


def compared(engine, loop: Loop) -> Compared:
    """Hold shooting from the loop's own start against simulation."""
    shot = shoot(engine, loop)["A"]
    if shot.verdict == "undetermined":
        return Compared(shot.verdict, 0.0, ())
    own = shot.basin["own"]  # the engine starts where the loop file says
    cycles = shot.cycles and own == shot.verdict
    close = CLOSE["sampled" if loop.sample_time else "continuous"]
    label, amplitude, period = simulated(engine, loop, shot.period if cycles else None, close)
    if label != ("cycle" if cycles else own):
        return Compared(own, 0.0, (f"{own} ({shot.status}), simulated: {label} {amplitude:.6g} rad {period:.6g} s",))
    if not cycles:
        return Compared(own, 0.0, ())
    settled = settle(engine, loop)["A"]
    pairs = {
        "amplitude": (shot.amplitude, amplitude), "period": (shot.period, period),
        "settled amplitude": (shot.amplitude, settled.amplitude), "settled period": (shot.period, settled.period),
    }  # fmt: skip
    off = {name: abs(one / other - 1.0) if other else math.inf for name, (one, other) in pairs.items()}
    wrong = [f"{name} {pairs[name]} off by {value:.2g} ({shot.status})" for name, value in off.items() if value > close]
    if not (shot.stable and shot.multipliers and max(abs(root) for root in shot.multipliers) < 1.0):
        wrong.append(f"multipliers {shot.multipliers} of a cycle that draws in")
    return Compared(own, max(off["amplitude"], off["period"]) / close, tuple(wrong))


def compare(engine_of, loop_of, seed: int, count: int) -> Counter[str]:
    """Assert that labels and sizes are the same in all loops, listing each that is off; return the verdicts."""
    rng = np.random.default_rng(seed)
    found = []
    for _ in range(count):
        friction, loop = draw(rng, loop_of)
        found.append((compared(engine_of(friction), loop), friction, loop))
    off = [f"case {i}: {text}; {f} {loop}" for i, (case, f, loop) in enumerate(found) for text in case.wrong]
    assert not off, "\n".join(off)
    worst = {kind: max((c.error for c, _, lp in found if (lp.sample_time > 0.0) == (kind == "sampled")), default=0.0)
             for kind in CLOSE}  # fmt: skip
    print({kind: f"{value * CLOSE[kind]:.2g}" for kind, value in worst.items()}, "worst relative errors")
    return Counter(case.verdict for case, _, _ in found)


def test_a_few_random_loops(engine_of, loop_of):
    seen = compare(engine_of, loop_of, seed=5, count=6)
    assert seen["rest"] >= 1


@pytest.mark.parametrize("smoothing", [0.01, 0.3])
def test_a_filter_keeps_the_sign_of_a_joint_that_stands_for_a_while_only(joint_a, loop_of, smoothing):
    """At rest a law of 1.2 times the friction moves the joint on, once the sign from before has died out."""
    settings = {"sample_time": 0.0125, "delay_samples": 1, "actuator_lag": 0.02, "velocity_filter": smoothing}
    loop = loop_of(1.2, "set_valued", kp=60.0, zeta=1.0, error=0.3, **settings)
    found, motion = shoot(joint_a, loop)["A"], close_loop(joint_a, loop).motion
    assert found.verdict == "hunting"
    assert 0.5 * np.ptp(motion.q[motion.filled // 2 :, 0]) == pytest.approx(found.amplitude, rel=1e-3)


@pytest.mark.parametrize(("amplitude", "frequency", "lag"), [(3.0, 2.0, 0.0), (2.0, 50.0, 0.01)])
def test_an_instant_without_motion_under_a_dither_is_no_rest(joint_a, amplitude, frequency, lag):
    law = Compensation("dither", amplitude=amplitude, frequency=frequency)
    entry = JointLoop("A", 30.0, Reference("regulate", initial_error=0.3), compensation=law, actuator_lag=lag)
    shaken = Loop(0.0, 100.0, (entry,), record_step=0.01)
    found, seen = settle(joint_a, shaken)["A"], close_loop(joint_a, shaken).motion.q[-1, 0]
    assert found.verdict == "rest"
    assert found.steady_error == pytest.approx(-seen, abs=5e-4)


def test_a_sampled_joint_that_sticks_is_not_at_rest_while_its_friction_fades(joint_a, loop_of):
    """Twice the friction holds an error of 0.3 rad, which what is left of it in the end does not."""
    fades = {"A": {"change": 1.0, "time": 20.0, "kept": 0.5}}
    arm = replace(joint_a.arm, effects=(EffectEntry("history", ("A",), fades, "in_time"),))
    regulated = replace(loop_of(error=0.3, sample_time=0.0125), duration=150.0)
    found, seen = shoot(arm, regulated)["A"], close_loop(RoundsEngine(arm), regulated).motion.q[-1, 0]
    assert found.verdict == "rest"
    assert found.steady_error == pytest.approx(-seen, rel=1e-6)


@pytest.mark.parametrize(
    ("effect", "law", "values"),
    [
        ("history", "in_time", {"change": 1.0, "time": 600.0, "kept": 0.5}),
        ("dwell_time", "frozen", {"rise": 0.5, "time": 1.0}),  # whose time at rest grows for ever
    ],
)
def test_a_sampled_joint_rests_where_what_still_changes_lets_it(joint_a, loop_of, effect, law, values):
    arm = replace(joint_a.arm, effects=(EffectEntry(effect, ("A",), {"A": values}, law),))
    assert shoot(arm, loop_of(error=0.15, sample_time=0.0125))["A"].verdict == "rest"
    assert settle(arm, loop_of(error=0.15, sample_time=0.0125))["A"].verdict == "rest"


def test_errors_are_those_of_the_measured_position(joint_a, loop_of):
    sensors = {
        "encoder_offset": {"offset": 0.1},
        "encoder_eccentricity": {"sine": 0.02, "cosine": 0.0, "harmonic": 9.0},
    }
    effects = tuple(EffectEntry(name, ("A",), {"A": values}) for name, values in sensors.items())
    engine = RoundsEngine(replace(joint_a.arm, effects=effects))
    for sample_time in (0.0, 0.0125):
        regulated = replace(loop_of(kp=60.0, error=0.3, sample_time=sample_time), duration=20.0)
        seen = close_loop(engine, regulated).motion.q[-1, 0]
        assert shoot(engine, regulated)["A"].steady_error == pytest.approx(-seen, rel=1e-6)
    hunts = replace(loop_of(0.9, "zero", ki=30.0), duration=100.0, record_step=0.01)
    found, motion = shoot(engine, hunts)["A"], close_loop(engine, hunts).motion
    late = motion.q[motion.t > motion.t[-1] - 1.2 * found.period, 0]
    assert found.amplitude == pytest.approx(0.5 * np.ptp(late), rel=2e-3)


def test_a_sampled_joint_that_slides_to_rest_settles_whatever_its_encoder_s_zero(joint_a, loop_of):
    slight = Friction(1e-6, 0.0, 1.5, 0.05)
    smooth = replace(joint_a.arm.joints[0], friction=slight, backward=slight)
    offset = EffectEntry("encoder_offset", ("A",), {"A": {"offset": 0.1}})
    regulated = loop_of(zeta=0.45, ki=10.0, sample_time=0.0125)
    for effects in ((), (offset,)):
        arm = replace(joint_a.arm, joints=(smooth,), effects=effects)
        found = shoot(arm, regulated)["A"]
        assert found.verdict == "rest"
        assert abs(found.steady_error) < 1e-5


@pytest.mark.slow
def test_two_hundred_random_loops(engine_of, loop_of):
    """No label is wrong, at most 2 % are left open, and no case is left out."""
    seen = compare(engine_of, loop_of, seed=1, count=200)
    print(seen)
    assert seen["undetermined"] <= 4
    assert seen.total() == 200
