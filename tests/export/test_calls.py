"""What an importer does wrong is refused with a line in the log, and does no harm."""

import ctypes
import math
from collections.abc import Callable
from pathlib import Path

import pytest

from stribeck.arm import Arm, EffectEntry

from .conftest import two_links
from .driver import ERROR, OK, Fmu, Instance


def said(it: Instance, text: str) -> bool:
    return bool(it.log) and it.log[-1][0] == ERROR and it.log[-1][1] == "logStatusError" and text in it.log[-1][2]


def test_steps_before_initialization(nominal: Fmu) -> None:
    it = nominal.instance()
    assert it.step(0.0, 0.01) == ERROR
    assert said(it, "DoStep must not be called before initialization")
    it.enter()
    assert it.step(0.0, 0.01) == ERROR
    assert said(it, "in initialization mode")
    assert it.call("ExitInitializationMode") == OK
    assert it.step(0.0, 0.01) == OK
    assert it.call("ExitInitializationMode") == ERROR
    assert it.call("Terminate") == OK
    assert it.step(0.01, 0.01) == ERROR
    assert said(it, "after termination")
    it.free()


@pytest.mark.parametrize("name", ["EnterEventMode", "EnterContinuousTimeMode", "Terminate", "ExitInitializationMode"])
def test_modes_out_of_order(nominal: Fmu, name: str) -> None:
    for kind in ("cs", "me"):
        it = nominal.instance(kind)
        assert it.call(name) == ERROR
        assert said(it, "must not be called")
        it.free()


def test_exchange_has_no_steps_and_steps_no_exchange(nominal: Fmu) -> None:
    me = nominal.instance("me").begin()
    assert me.step(0.0, 0.01) == ERROR
    me.free()
    cs = nominal.instance().begin()
    assert cs.call("EnterContinuousTimeMode") == ERROR
    x = (ctypes.c_double * 4)()
    assert cs.call("SetContinuousStates", x, ctypes.c_size_t(4)) == ERROR
    cs.free()


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_values_that_are_no_numbers(nominal: Fmu, value: float) -> None:
    it = nominal.instance().begin()
    for name in ("tau[1]", "joint[1].mass"):
        before = it.get(name)
        assert it.try_set({name: value}) == ERROR
        assert it.get(name) == before
    assert it.step(0.0, value) == ERROR
    assert it.step(0.0, 0.01) == OK
    it.free()
    me = nominal.instance("me").begin()
    x = (ctypes.c_double * 4)(0.0, value, 0.0, 0.0)
    assert me.call("SetContinuousStates", x, ctypes.c_size_t(4)) == ERROR
    assert me.call("SetTime", ctypes.c_double(value)) == ERROR
    me.free()


def test_what_cannot_be_set(nominal: Fmu) -> None:
    it = nominal.instance().begin()
    for name in ("q[1]", "dq_start[1]", "joint[1].q", "joint[1].length", "sliding[1]"):
        assert it.try_set({name: 1.0}) == ERROR, name
    assert it.try_set({"joint[1].mass": -1.0}) == ERROR
    assert said(it, "must lie between")
    it.free()


def test_what_is_so_already_may_be_set_at_any_time(nominal: Fmu) -> None:
    """As gemseo-fmu and older OpenModelicas do with all parameters after initialization, fixed ones too."""
    it = nominal.instance("me").begin({"q_start[1]": 0.25})
    same = {name: it.get(name)[0] for name in ("q_start[1]", "dq_start[2]", "joint[1].mass")}
    assert same["q_start[1]"] == 0.25
    assert it.try_set(same) == OK
    assert it.try_set({"q_start[1]": 0.5}) == ERROR
    assert it.get("q_start[1]") == [0.25]
    assert it.try_set({"joint[1].mass": same["joint[1].mass"] + 0.1}) == ERROR  # continuous time: no tuning
    it.free()


@pytest.mark.parametrize("kind", ["cs", "me"])
def test_how_an_effect_starts_is_not_told_later(made: Callable[[Arm, int], Path], kind: str) -> None:
    values = {"change": 0.3, "time": 20.0, "start": 0.1, "kept": 0.4}
    fmu = Fmu(made(two_links(EffectEntry("history", ("A",), {"A": values})), 2))
    it = fmu.instance(kind).begin({"effect.history[1].start": 0.2})
    assert list(it.get("effect.history[1].start", "effect.history[1].state.warmth")) == [0.2, 0.2]
    assert it.try_set({"effect.history[1].start": 0.2}) == OK
    assert it.try_set({"effect.history[1].start": 0.3}) == ERROR
    assert it.get("effect.history[1].start") == [0.2]
    it.free()


def test_unknown_value_references(nominal: Fmu) -> None:
    it = nominal.instance().begin()
    out, vr = (ctypes.c_double * 1)(), (ctypes.c_uint32 * 1)(4000000000)
    more = () if nominal.fmi == 2 else (ctypes.c_size_t(1),)
    for get, get3 in (("GetReal", "GetFloat64"), ("SetReal", "SetFloat64"), ("GetInteger", "GetInt32")):
        assert it.call(get, vr, ctypes.c_size_t(1), out, *more, name3=get3) == ERROR
    assert it.call("GetBoolean", vr, ctypes.c_size_t(1), out, *more) == ERROR
    assert it.call("GetBoolean", vr, ctypes.c_size_t(0), out, *(ctypes.c_size_t(0),) * len(more)) == OK
    it.free()


def test_a_step_from_another_time(nominal: Fmu) -> None:
    it = nominal.instance().begin()
    assert it.step(0.5, 0.01) == ERROR
    assert said(it, "time stands at 0")
    assert it.step(0.0, -0.01) == ERROR
    assert it.step(0.0, 0.0) == ERROR
    it.free()


def test_a_step_twice_or_left_out_late_in_a_simulation(nominal: Fmu) -> None:
    start, h = 2.0**20, 2.0**-12  # what is told from a whole second is not from so short a step
    it = nominal.instance().begin(start=start)
    assert it.step(start, h) == OK
    assert it.step(start, h) == ERROR
    assert it.step(start + 2.0 * h, h) == ERROR
    assert it.step(start + h, h) == OK
    it.free()


def test_a_time_that_is_added_up_is_the_same_time(nominal: Fmu) -> None:
    """Every second step begins at a multiple of the step, the others where a running sum is."""
    it, t, h = nominal.instance().begin(), 0.0, 1e-3
    for k in range(10_000):
        assert it.step(k * h if k % 2 else t, h) == OK
        t += h
    assert abs(t - 10.0) > 1e-13
    it.free()


def test_a_wrong_token(nominal: Fmu) -> None:
    right, nominal.token = nominal.token, "{0}"
    try:
        it = nominal.instance()
    finally:
        nominal.token = right
    assert it.c is None
    assert said(it, "is not that of this FMU")


def test_null_instances_are_refused(nominal: Fmu) -> None:
    it = nominal.instance()
    kept, it.c = it.c, None
    assert it.step(0.0, 0.01) == ERROR
    assert it.call("Terminate") == ERROR
    it.free()
    it.c = kept
    it.free()


def test_log_categories(nominal: Fmu) -> None:
    it = nominal.instance(log_on=False).begin({"dq_start[1]": 0.1})
    assert it.step(0.0, 0.2) == OK
    assert it.log == []
    on = ctypes.c_int(1) if nominal.fmi == 2 else ctypes.c_bool(True)
    names = (ctypes.c_char_p * 1)(b"logEvents")
    assert it.call("SetDebugLogging", on, ctypes.c_size_t(1), names) == OK
    it.put({"tau[1]": 20.0})
    assert it.step(0.2, 0.2) == OK
    assert {category for _, category, _ in it.log} == {"logEvents"}
    assert it.step(9.0, 0.2) == ERROR
    assert len(it.log) == 1  # errors were not asked for
    assert it.call("SetDebugLogging", on, ctypes.c_size_t(1), (ctypes.c_char_p * 1)(b"logNothing")) == ERROR
    it.free()


def test_an_unbounded_motion_is_discarded(nominal: Fmu) -> None:
    it = nominal.instance().begin({"tau[1]": 1e9})
    assert it.step(0.0, 1.0) == 2
    assert "unbounded" in it.log[-1][2]
    it.free()


def test_inputs_of_event_mode_are_seen_at_once(nominal3: Fmu, made: Callable[[Arm, int], Path]) -> None:
    """The friction that holds a stuck joint is that of the torque just set; a motion from there is as without."""
    late = Fmu(made(two_links(EffectEntry("delay", ("A",), {"A": {"time": 0.037}})), 3))
    for fmu, held in ((nominal3, 2.0), (late, 0.0)):
        it = fmu.instance(event_mode=True, early=True)
        it.enter()
        assert it.call("ExitInitializationMode") == OK
        it.update()
        it.put({"tau[1]": 2.0})
        assert abs(it.get("tau_friction[1]")[0]) == held
        it.put({"tau[1]": 9.0})
        it.update()
        assert it.get("sliding[1]")[0] == (1.0 if held else 0.0)
        assert it.call("EnterStepMode") == OK
        plain = fmu.instance().begin()
        plain.put({"tau[1]": 9.0})
        for one in (it, plain):
            assert one.step(0.0, 0.2) == OK
        if it.reached.value == 0.2:
            assert it.get("q[1]") == plain.get("q[1]")
        it.free()
        plain.free()


def test_event_mode_of_steps(nominal3: Fmu) -> None:
    """Early return: each event ends a step, is passed in event mode, and the motion is that without it."""
    it = nominal3.instance(event_mode=True, early=True)
    it.put({"dq_start[1]": 0.4, "tau[2]": 2.9})
    it.enter()
    assert it.call("ExitInitializationMode") == OK
    it.update()
    assert it.call("EnterStepMode") == OK
    t, returned = 0.0, []
    while t < 0.5 - 1e-12:
        assert it.step(t, 0.5 - t) == OK
        t = it.reached.value
        if it.flags[0].value:  # event handling needed
            assert it.flags[2].value == (t < 0.5)
            before = it.get("sliding[1]")
            assert it.call("EnterEventMode") == OK
            assert it.update()
            returned.append((t, before[0], it.get("sliding[1]")[0]))
            assert it.call("EnterStepMode") == OK
    plain = nominal3.instance().begin({"dq_start[1]": 0.4, "tau[2]": 2.9})
    assert plain.step(0.0, 0.5) == OK
    assert abs(it.get("q[1]", "q[2]") - plain.get("q[1]", "q[2]")).max() < 1e-9
    assert it.get_integer("events") == plain.get_integer("events") == [len(returned)]
    assert returned[0][1:] == (1.0, 0.0)
    it.free()
    plain.free()
