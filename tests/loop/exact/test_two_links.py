"""Cycles of both joints of the two-link arm, coupled, against simulation by the closed-loop engine."""

import math
from dataclasses import replace

import numpy as np
import pytest

from stribeck.loop.exact.shooting import shoot
from stribeck.simulate import Compensation, JointLoop, Loop, Reference, close_loop

GAINS = {"A": (40.0, 150.0), "B": (15.0, 60.0)}


def draw(rng, inertia, hunts: bool) -> Loop:
    """Return random loops of both joints: over-compensated, or under-compensated PID."""
    entries = []
    for (name, (low, high)), j in zip(GAINS.items(), inertia, strict=True):
        kp = float(rng.uniform(low, high))
        kv = 2.0 * float(rng.uniform(0.15, 0.7)) * math.sqrt(kp * j)
        rule = "zero" if hunts else str(rng.choice(["set_valued", "error_sign"]))
        ratio = float(rng.uniform(0.5, 0.95) if hunts else rng.uniform(1.05, 1.4))
        start = Reference("regulate", initial_error=float(rng.uniform(0.2, 0.6)))
        ki = 0.15 * kp * kv / j if hunts else 0.0
        law = Compensation("feedback", ratio, rule)
        entries.append(JointLoop(name, kp, start, kv=kv, ki=ki, compensation=law))
    return Loop(0.0, 60.0, tuple(entries), record_step=0.005)


def check(engine, seed: int, count: int) -> list[str]:
    rng, inertia = np.random.default_rng(seed), engine.moved_inertia(np.zeros(2))
    seen = []
    for i in range(count):
        loop = draw(rng, inertia, hunts=i % 4 == 3)
        found = shoot(engine, loop)
        longest = max(cycle.period or 1.0 for cycle in found.values())
        simulated = close_loop(engine, replace(loop, duration=80.0 * longest + 60.0), tolerance=1e-9)
        late = slice(len(simulated.motion.t) // 2, None)
        for j, cycle in enumerate(found.values()):
            q, t = simulated.motion.q[late, j], simulated.motion.t[late]
            seen.append(cycle.verdict)
            assert cycle.cycles == (np.ptp(q) > 2e-5)
            if not cycle.cycles:
                continue
            assert cycle.amplitude == pytest.approx(0.5 * np.ptp(q), rel=5e-3)
            # ten periods on it is where it was: a period 0.1 % off would be 6 % of a radian of phase off
            begin = t < t[-1] - 10.0 * cycle.period
            again = np.interp(t[begin] + 10.0 * cycle.period, t, q)
            assert np.abs(again - q[begin]).max() < 0.05 * cycle.amplitude
    return seen


def test_coupled_cycles(level_arm):
    assert set(check(level_arm, seed=1, count=4)) >= {"sliding_cycle", "hunting"}


def test_a_joint_that_winds_up_is_not_at_rest(level_arm):
    """Coupled hunting need not repeat: a joint that stuck while the other settled is left open, not called rest."""
    rng, inertia = np.random.default_rng(1), level_arm.moved_inertia(np.zeros(2))
    draw(rng, inertia, hunts=False)
    found = shoot(level_arm, draw(rng, inertia, hunts=True))
    assert found["A"].verdict == "undetermined"
    assert found["B"].verdict == "hunting"


@pytest.mark.slow
def test_twenty_coupled_cycles(level_arm):
    assert set(check(level_arm, seed=2, count=20)) <= {"sliding_cycle", "hunting", "rest"}


def test_a_resting_joint_beside_a_cycling_one(level_arm):
    """Joint B is over-compensated and cycles; A, under PD without compensation, is shaken but holds."""
    entries = (
        JointLoop("A", 300.0, Reference("regulate"), kv=60.0),
        JointLoop(
            "B", 30.0, Reference("regulate", initial_error=0.3), kv=1.0,
            compensation=Compensation("feedback", 1.2, "set_valued"),
        ),
    )  # fmt: skip
    found = shoot(level_arm, Loop(0.0, 60.0, entries))
    assert found["B"].verdict == "sliding_cycle"
    assert found["A"].verdict == "rest"
