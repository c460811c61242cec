"""The engine against an independent simulation: other equations, other integrator, other event location."""

import numpy as np
import pytest

from stribeck.simulate import Engine, JointLoop, Loop, close_loop
from stribeck.simulate import Reference as Follow

from .conftest import two_links
from .reference import Reference

STEP, SAMPLES = 0.0125, 401


def held_command() -> np.ndarray:
    t = STEP * np.arange(SAMPLES)
    return np.stack([11.0 * np.sin(2.6 * t) + 4.0 * np.sin(9.0 * t), 3.6 * np.sin(3.7 * t + 0.5)], axis=1)


@pytest.mark.long
def test_sampled_command_with_gravity(hanging_arm: Engine) -> None:
    command, times = held_command(), STEP * np.arange(SAMPLES)
    reference = Reference(two_links(gravity=(9.81, 0.0)))
    y, log = np.array([0.2, -0.3, 0.0, 0.0]), []
    modes = reference.choose(y, command[0])
    expected = [y]
    for k in range(SAMPLES - 1):
        u = command[k]
        before = modes
        if 0.0 in y[2:]:
            modes = reference.choose(y, u)
        log += [(times[k], j) for j in (0, 1) if k and modes[j] != before[j]]
        y, modes = reference.advance(y, times[k], times[k + 1], lambda s, z, u=u: u, modes, log)
        expected.append(y)
    found = hanging_arm.run(hanging_arm.p, expected[0], times, command, tolerance=1e-8)
    assert found.ok
    assert len(log) >= 10
    assert [j for _, j in log] == found.events["joint"].tolist()
    assert np.abs(np.array([t for t, _ in log]) - found.events["time"]).max() < 1e-6
    assert np.abs(np.array(expected)[:, :2] - found.q).max() < 1e-8


@pytest.mark.long
def test_break_away_between_samples(level_arm: Engine) -> None:
    """A continuous PD drags both joints so slowly that they stick and slip; every break-away falls between rows."""
    gains = ((300.0, 1.0, 0.03), (150.0, 0.5, -0.03))
    loop = Loop(
        0.0,
        5.0,
        tuple(
            JointLoop(name, kp, Follow("ramp", velocity=v), kv=kv)
            for name, (kp, kv, v) in zip("AB", gains, strict=True)
        ),
        record_step=0.05,
    )
    found = close_loop(level_arm, loop, tolerance=1e-8)
    kp, kv, v = (np.array(column) for column in zip(*gains, strict=True))

    def command(s: float, z: np.ndarray) -> np.ndarray:
        return kp * (v * s - z[:2]) + kv * (v - z[2:])

    reference, y, log = Reference(two_links()), np.zeros(4), []
    modes = reference.choose(y, command(0.0, y))
    for k, t in enumerate(found.motion.t):
        assert np.abs(y[:2] - found.motion.q[k]).max() < 1e-8
        y, modes = reference.advance(y, t, t + 0.05, command, modes, log)
    log = [(t, j) for t, j in log if t <= 5.0]
    assert len(log) >= 10
    assert [j for _, j in log] == found.motion.events["joint"].tolist()
    assert np.abs(np.array([t for t, _ in log]) - found.motion.events["time"]).max() < 1e-6


@pytest.mark.parametrize("engine", ["level_arm", "hanging_arm"])
def test_equations_of_motion(engine: str, request: pytest.FixtureRequest) -> None:
    built: Engine = request.getfixturevalue(engine)
    reference, rng = Reference(built.path.arm), np.random.default_rng(3)
    for _ in range(20):
        y, u = rng.normal(size=4), 10 * rng.normal(size=2)
        for modes in ((1, 1), (-1, 1), (1, -1), (-1, -1), (0, 1), (-1, 0), (0, 0)):
            y[2:] = np.abs(y[2:]) * modes
            rates, margins = (v.full().ravel() for v in built.forward.flow(0.0, y, modes, u, built.p))
            a, held = reference.accelerations(y, u, modes)
            assert rates == pytest.approx(np.concatenate([y[2:], a]), rel=1e-11, abs=1e-11)
            for j in (0, 1):
                if modes[j] == 0:
                    rest = reference.level(j, 0.0)
                    assert margins[[j, 2 + j]] == pytest.approx([rest - held[j], rest + held[j]], rel=1e-11, abs=1e-11)
