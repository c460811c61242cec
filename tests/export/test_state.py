"""Copies of the FMU's state: rollback to the last bit, bytes that carry it elsewhere, and bytes that are refused."""

import numpy as np
import pytest

from .driver import ERROR, OK, Fmu, Instance

LOOK = ("q[1]", "q[2]", "dq[1]", "dq[2]", "tau_friction[1]", "tau_friction[2]", "sliding[1]", "sliding[2]", "time")


def on(it: Instance, t: float, steps: int) -> np.ndarray:
    rows = []
    for k in range(steps):
        it.put({"tau[1]": 9.0 * np.sin(30.0 * (t + 0.01 * k)), "tau[2]": 4.0 * np.cos(21.0 * (t + 0.01 * k))})
        assert it.step(t + 0.01 * k, 0.01) == OK
        rows.append(it.get(*LOOK))
    return np.array(rows)


def test_rollback_is_bitwise(nominal: Fmu) -> None:
    it = nominal.instance().begin({"dq_start[1]": 0.3})
    on(it, 0.0, 20)
    state = it.keep()
    first = on(it, 0.2, 60)
    it.put({"joint[1].friction.C0": 1.0, "tau[1]": 77.0})
    it.restore(state)
    np.testing.assert_array_equal(on(it, 0.2, 60), first)
    assert len(np.unique(first[:, 6])) > 1  # there were events in between
    it.keep(state)  # the same object again
    it.drop(state)
    it.free()


def test_bytes_go_on_in_another_instance(nominal: Fmu) -> None:
    it = nominal.instance().begin({"dq_start[2]": 0.3})
    on(it, 0.0, 20)
    state = it.keep()
    data = it.to_bytes(state)
    first = on(it, 0.2, 40)
    other = nominal.instance().begin()
    status, copy = other.from_bytes(data)
    assert status == OK
    other.restore(copy)
    np.testing.assert_array_equal(on(other, 0.2, 40), first)
    for each, kept in ((it, state), (other, copy)):
        each.drop(kept)
        each.free()


def test_states_of_exchange(nominal: Fmu) -> None:
    me = nominal.instance("me").begin({"dq_start[1]": 0.2})
    state = me.keep()
    before, rates = me.y(), me.rates()
    me.at(0.5, before + 0.1)
    me.restore(state)
    np.testing.assert_array_equal(me.y(), before)
    np.testing.assert_array_equal(me.rates(), rates)
    me.drop(state)
    me.free()


@pytest.mark.parametrize(
    ("harm", "said"),
    [
        (lambda data: data[:-1], "truncated"),
        (lambda data: data[:20], "too short"),
        (lambda data: b"", "too short"),
        (lambda data: data + b"\0", "truncated"),
        (lambda data: b"X" + data[1:], "kind"),
        (lambda data: data[:8] + b"\x09" + data[9:], "version"),
        (lambda data: data[:32] + b"\0" * 8 + data[40:], "another model"),
        (lambda data: data[:200] + bytes([data[200] ^ 1]) + data[201:], "damaged"),
    ],
)
def test_wrong_bytes_are_refused(nominal: Fmu, harm: object, said: str) -> None:
    it = nominal.instance().begin()
    state = it.keep()
    status, copy = it.from_bytes(harm(it.to_bytes(state)))  # type: ignore[operator]
    assert status == ERROR
    assert not copy.value
    assert said in it.log[-1][2]
    assert it.step(0.0, 0.01) == OK
    it.drop(state)
    it.free()


def test_reset_starts_anew(nominal: Fmu) -> None:
    it = nominal.instance().begin({"dq_start[1]": 0.3})
    first = on(it, 0.0, 10)
    it.put({"joint[2].mass": 3.0})
    assert it.call("Reset") == OK
    assert it.get("joint[2].mass", "dq_start[1]").tolist() == [2.0, 0.0]
    it.begin({"dq_start[1]": 0.3})
    np.testing.assert_array_equal(on(it, 0.0, 10), first)
    it.free()
