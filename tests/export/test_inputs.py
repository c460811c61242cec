"""Inputs: held, ramped by FMI 2's input derivatives, delayed by an effect; parameters tuned on the way."""

import ctypes
from collections.abc import Callable
from pathlib import Path

import numpy as np

from stribeck.arm import Arm, EffectEntry
from stribeck.simulate import Engine, path_of

from .conftest import two_links
from .driver import ERROR, OK, Fmu, Instance

DELAYED = two_links(EffectEntry("delay", ("A", "B"), {"A": {"time": 0.037}, "B": {"time": 0.005}}))


def ramp(it: Instance, values: dict[str, float]) -> int:
    vr, order = it._vrs(list(values)), (ctypes.c_int * len(values))(*[1] * len(values))
    slopes = (ctypes.c_double * len(values))(*values.values())
    return it.call("SetRealInputDerivatives", vr, ctypes.c_size_t(len(values)), order, slopes)


def test_a_ramp_is_followed_between_communication_points(made: Callable[[Arm, int], Path]) -> None:
    """Long steps with a slope equal short ones with the ramp's values, at the second order of the latter."""
    fmu = Fmu(made(two_links(), 2))
    long = fmu.instance().begin()
    for k in range(5):
        long.put({"tau[1]": 0.0 + 4.0 * k, "tau[2]": 0.0 - 2.0 * k})
        assert ramp(long, {"tau[1]": 4.0 / 0.1, "tau[2]": -2.0 / 0.1}) == OK
        assert long.step(0.1 * k, 0.1) == OK
    errors = []
    for count in (500, 1000):
        short, h = fmu.instance().begin(), 0.5 / count
        for i in range(count):
            short.put({"tau[1]": 40.0 * (i + 0.5) * h, "tau[2]": -20.0 * (i + 0.5) * h})
            assert short.step(i * h, h) == OK
        errors.append(np.abs(short.get("q[1]", "q[2]") - long.get("q[1]", "q[2]")).max())
        short.free()
    assert errors[0] < 1e-4
    assert errors[1] < 0.6 * errors[0]
    long.free()


def test_break_away_on_a_ramp_comes_at_its_instant(made: Callable[[Arm, int], Path]) -> None:
    """Joint B alone: the torque passes 2.8 N m at t = 0.28 s of one step of 1 s."""
    it = Fmu(made(two_links(), 2)).instance().begin()
    assert ramp(it, {"tau[2]": 10.0}) == OK
    assert it.step(0.0, 0.2799) == OK
    assert it.get("q[2]")[0] == 0.0
    it.put({"tau[2]": 2.799})
    assert ramp(it, {"tau[2]": 10.0}) == OK
    assert it.step(0.2799, 0.1) == OK
    assert it.get("sliding[2]")[0] == 1.0
    assert any("t = " in text for _, _, text in it.log)
    it.free()


def test_a_ramp_is_of_one_step(made: Callable[[Arm, int], Path]) -> None:
    """Set once, with and without a delay: the steps after it hold the value that was set, to the same motion."""
    motions = []
    for arm, start in ((two_links(), 0.0), (DELAYED, 0.037)):
        it = Fmu(made(arm, 2)).instance().begin({"tau[1]": 7.0}, tolerance=1e-11)
        assert it.step(0.0, 0.1 - start) == OK
        assert ramp(it, {"tau[1]": 200.0}) == OK
        for k in range(5):
            assert it.step(0.1 - start + 0.02 * k, 0.02) == OK
        assert it.step(0.2 - start, 0.1 + start) == OK
        motions.append(it.get("q[1]", "dq[1]"))
        it.free()
    np.testing.assert_allclose(motions[1], motions[0], rtol=0.0, atol=1e-9)


def test_only_inputs_have_derivatives(made: Callable[[Arm, int], Path]) -> None:
    it = Fmu(made(two_links(), 2)).instance().begin()
    assert ramp(it, {"q[1]": 1.0}) == ERROR
    assert ramp(it, {"tau[1]": float("nan")}) == ERROR
    it.free()


def test_delays_that_are_no_multiple_of_the_step(made: Callable[[Arm, int], Path]) -> None:
    fmu, engine = Fmu(made(DELAYED, 3)), Engine(path_of(DELAYED))
    times = 0.01 * np.arange(101)
    command = np.stack([9.0 * np.sin(12.0 * times), 4.0 * np.cos(9.0 * times)], axis=1)
    own = engine.run(engine.p, engine.start(engine.p, np.zeros(2)), times, command)
    it, rows = fmu.instance().begin({"tau[1]": command[0, 0], "tau[2]": command[0, 1]}), []
    for k, t in enumerate(times):
        rows.append(it.get("q[1]", "q[2]"))
        it.put({"tau[1]": command[k, 0], "tau[2]": command[k, 1]})
        if k == 50:  # what is on its way belongs to the state
            state = it.keep()
            assert it.step(t, 0.2) == OK
            it.restore(state)
            it.drop(state)
        if k + 1 < len(times):
            assert it.step(t, 0.01) == OK
    it.free()
    assert own.event_count > 3
    np.testing.assert_allclose(np.array(rows), own.q, rtol=0, atol=1e-10)


def test_a_delay_refuses_exchange_in_one_line(made: Callable[[Arm, int], Path]) -> None:
    me = Fmu(made(DELAYED, 3)).instance("me")
    assert me.c is None
    ((status, _, text),) = me.log
    assert status == ERROR
    assert text.startswith("the pure delay at joint A and B needs past inputs, which Model Exchange cannot carry")


def test_too_many_commands_on_their_way(made: Callable[[Arm, int], Path]) -> None:
    it = Fmu(made(DELAYED, 3)).instance(log_on=True).begin()
    status, k = OK, 0
    while status == OK and k < 5000:
        it.put({"tau[1]": 1e-3 * k})
        status, k = it.step(1e-6 * k, 1e-6), k + 1
    assert status == ERROR
    assert k > 4000
    assert "take longer steps" in it.log[-1][2]
    it.free()


def test_parameters_are_tuned_on_the_way(nominal: Fmu) -> None:
    """A stuck joint lets go once its friction is lowered below the torque that it holds."""
    for kind in ("cs", "me"):
        it = nominal.instance(kind).begin({"tau[1]": 6.0})
        assert it.get("sliding[1]")[0] == 0.0
        if kind == "cs":
            it.put({"joint[1].friction.C0": 4.0})
            assert it.step(0.0, 0.01) == OK
        else:
            assert it.try_set({"joint[1].friction.C0": 4.0}) == ERROR  # in continuous-time mode
            assert it.call("EnterEventMode") == OK
            it.put({"joint[1].friction.C0": 4.0})
            it.update()
        assert it.get("sliding[1]")[0] == 1.0
        it.free()
