"""An exported FMU moves as the arm's own simulator and as an independent reference, in both kinds and versions."""

import numpy as np
import pytest

from stribeck.simulate import Engine

from ..simulate.reference import Reference
from .driver import OK, Fmu
from .exchange import euler, exchanged

STEP, SAMPLES = 0.0125, 121
# the binary of either version holds the same equations, which other tests compare in both
ONE_VERSION = pytest.mark.parametrize("nominal", [2, pytest.param(3, marks=pytest.mark.slow)], indirect=True)
TIMES = STEP * np.arange(SAMPLES)
COMMAND = np.stack([11.0 * np.sin(2.6 * TIMES) + 4.0 * np.sin(9.0 * TIMES), 3.6 * np.sin(3.7 * TIMES + 0.5)], axis=1)


@pytest.fixture(scope="module")
def expected(engine: Engine) -> tuple[np.ndarray, list[tuple[float, int]]]:
    """Position (M, 2) and changes of mode (time, joint), by Lagrange's equations and scipy."""
    independent = Reference(engine.path.arm)
    y, log = np.zeros(4), list[tuple[float, int]]()
    modes, rows = independent.choose(y, COMMAND[0]), [np.zeros(2)]
    for k in range(SAMPLES - 1):
        u, before = COMMAND[k], modes
        if 0.0 in y[2:]:
            modes = independent.choose(y, u)
        log += [(TIMES[k], j) for j in (0, 1) if k and modes[j] != before[j]]
        y, modes = independent.advance(y, TIMES[k], TIMES[k + 1], lambda s, z, u=u: u, modes, log)
        rows.append(y[:2])
    return np.array(rows), log


def stepped(fmu: Fmu, times: np.ndarray, command: np.ndarray) -> tuple[np.ndarray, int]:
    cs, rows = fmu.instance().begin({"tau[1]": command[0, 0], "tau[2]": command[0, 1]}), []
    for k, t in enumerate(times):
        rows.append(cs.get("q[1]", "q[2]", "dq[1]", "dq[2]"))
        if k + 1 < len(times):
            cs.put({"tau[1]": command[k, 0], "tau[2]": command[k, 1]})
            assert cs.step(t, times[k + 1] - t) == OK
    (events,) = cs.get_integer("events")
    cs.free()
    return np.array(rows), events


def test_steps_as_the_simulator(nominal: Fmu, engine: Engine) -> None:
    found, events = stepped(nominal, TIMES, COMMAND)
    own = engine.run(engine.p, engine.start(engine.p, np.zeros(2)), TIMES, COMMAND)
    assert own.event_count >= 3
    np.testing.assert_allclose(found, np.hstack([own.q, own.dq]), rtol=0, atol=1e-12)
    assert events == own.event_count


def test_steps_as_the_reference(nominal: Fmu, expected: tuple[np.ndarray, list[tuple[float, int]]]) -> None:
    found, events = stepped(nominal, TIMES, COMMAND)
    assert np.abs(found[:, :2] - expected[0]).max() < 1e-8
    assert events == len(expected[1])


def test_is_exchanged_as_the_reference(
    nominal: Fmu, engine: Engine, expected: tuple[np.ndarray, list[tuple[float, int]]]
) -> None:
    me = nominal.instance("me").begin()
    found, _ = exchanged(me, TIMES, COMMAND, rtol=1e-8)
    (events,) = me.get_integer("events")
    me.free()
    assert np.abs(found[:, :2] - expected[0]).max() < 1e-6
    assert events == len(expected[1])
    own = engine.run(engine.p, engine.start(engine.p, np.zeros(2)), TIMES, COMMAND)
    np.testing.assert_array_equal(found[:, 4:], own.modes)


@pytest.mark.parametrize("kind", ["cs", "me"])
@pytest.mark.parametrize("joint", [1, 2])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_breaks_away_at_the_level_and_not_below(nominal: Fmu, kind: str, joint: int, sign: float) -> None:
    level = [6.25, 2.8][joint - 1]
    above = np.nextafter(level, 10.0) * (1 + 1e-12)
    for torque, slides in ((level, False), (above, True)):
        it = nominal.instance(kind).begin({f"tau[{joint}]": sign * torque})
        assert it.get(f"sliding[{joint}]")[0] == (sign if slides else 0.0)
        assert it.get(f"sliding[{3 - joint}]")[0] == 0.0
        it.free()


@pytest.mark.parametrize("kind", ["cs", "me"])
def test_a_stuck_arm_does_not_drift(nominal: Fmu, kind: str) -> None:
    times = 0.1 * np.arange(21)
    command = np.stack([6.24 * np.sin(40.0 * times), 2.79 * np.cos(37.0 * times)], axis=1)
    start = {"q_start[1]": 0.3, "q_start[2]": -0.7}
    it = nominal.instance(kind).begin(start)
    if kind == "me":
        found, events = exchanged(it, times, command)
        assert events == 0
        q, dq = found[:, :2], found[:, 2:4]
    else:
        rows = []
        for k, t in enumerate(times):
            it.put({"tau[1]": command[k, 0], "tau[2]": command[k, 1]})
            assert it.step(t, 0.1) == OK
            rows.append(it.get("q[1]", "q[2]", "dq[1]", "dq[2]"))
        q, dq = np.array(rows)[:, :2], np.array(rows)[:, 2:]
    it.free()
    assert (q == [0.3, -0.7]).all()
    assert (dq == 0.0).all()


def test_an_importer_that_loses_the_jump_does_not_creep(nominal: Fmu) -> None:
    me = nominal.instance("me").begin({"dq_start[1]": 0.5})
    y = me.y()
    y[2] = -1e-3  # a step past standstill
    me.at(0.1, y)
    assert me.event()
    me.at(0.2, y)  # the importer goes on from its own value
    assert me.get("sliding[1]", "dq[1]", "der(joint[1].q)", "der(joint[1].dq)").tolist() == [0.0, 0.0, 0.0, 0.0]
    me.free()


def test_variable_steps_change_nothing(nominal: Fmu) -> None:
    """The same motion, whatever the communication steps, to the tolerance."""
    ends = []
    for steps in ([1.0], [0.25] * 4, [0.1, 0.37, 0.03, 0.5]):
        cs = nominal.instance().begin({"tau[1]": 8.0, "tau[2]": -3.5, "dq_start[1]": -0.4})
        t = 0.0
        for h in steps:
            assert cs.step(t, h) == OK
            t += h
        ends.append(cs.get("q[1]", "q[2]"))
        cs.free()
    assert np.abs(np.array(ends) - ends[0]).max() < 1e-8


@ONE_VERSION
def test_euler_converges_at_first_order(nominal: Fmu, engine: Engine) -> None:
    """Sliding and standstill under a fixed step: first order, the right modes at 1 ms.

    Each standstill is late by part of a step, by chance; the mean over several starts shows the order.
    """
    command, fine = np.array([3.0, -1.0]), 1e-3 * np.arange(401)
    steps, errors = np.array([2e-3, 1e-3, 5e-4, 2.5e-4]), np.zeros(4)
    for speed in (0.3, 0.37, 0.44, 0.51, 0.58):
        state = engine.start(engine.p, np.array([0.0, 0.5]), np.array([speed, 0.6]))
        own = engine.run(engine.p, state, fine, np.tile(command, (401, 1)))
        assert own.event_count >= 2
        for i, h in enumerate(steps):
            me = nominal.instance("me").begin({"dq_start[1]": speed, "dq_start[2]": 0.6, "q_start[2]": 0.5})
            found = euler(me, 0.4, h, command)
            me.free()
            errors[i] += np.abs(found[-1, :2] - own.q[-1]).sum()
            if h == 1e-3:
                late = np.abs(found[:, 2:] - own.modes).sum(axis=0)
                assert (late <= 2).all()  # a mode changes within two steps of when it should
    order = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert 0.8 < order < 1.3
