"""Directional and adjoint derivatives against central differences, in all nine modes and in initialization."""

import itertools
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from stribeck.arm import Arm

from .driver import OK, Fmu, Instance
from .test_inputs import DELAYED

OUT = ["q[1]", "q[2]", "dq[1]", "dq[2]", "tau_friction[1]", "tau_friction[2]"]
RATES = [f"der(joint[{j}].{key})" for key in ("q", "dq") for j in (1, 2)]
EDGES = ["joint[1].event_indicator", "joint[2].event_indicator"]
STATES = ["joint[1].q", "joint[2].q", "joint[1].dq", "joint[2].dq"]
INPUTS = ["tau[1]", "tau[2]"]
MODES = list(itertools.product((-1, 0, 1), repeat=2))


def placed(fmu: Fmu, modes: tuple[int, int]) -> tuple[Instance, np.ndarray]:
    """An instance in continuous-time mode whose joints slide or stick as asked."""
    start = {f"dq_start[{j + 1}]": 0.07 * m for j, m in enumerate(modes)}
    me = fmu.instance("me").begin(start | {"q_start[1]": 0.4, "q_start[2]": -0.9, "tau[1]": 0.3, "tau[2]": -0.2})
    assert me.get("sliding[1]", "sliding[2]").tolist() == list(modes)
    return me, me.y()


def differences(me: Instance, y: np.ndarray, unknown: list[str], known: list[str]) -> np.ndarray:
    """Matrix (unknown, known) by central differences of fourth order."""
    columns = []
    base = me.get(*INPUTS)
    for name in known:
        column = 0.0
        for factor, weight in ((1, 8), (-1, -8), (2, -1), (-2, 1)):
            moved, u, h = y.copy(), base.copy(), 2e-4
            if name in STATES:
                moved[STATES.index(name)] += factor * h
            else:
                u[INPUTS.index(name)] += factor * h
            me.put(dict(zip(INPUTS, u, strict=True)))
            me.at(0.0, moved)
            column = column + weight * me.get(*unknown) / (12.0 * h)
        columns.append(column)
    me.put(dict(zip(INPUTS, base, strict=True)))
    me.at(0.0, y)
    return np.array(columns).T


@pytest.mark.parametrize("modes", MODES)
def test_against_differences(nominal: Fmu, modes: tuple[int, int]) -> None:
    me, y = placed(nominal, modes)
    unknown = OUT + RATES + EDGES
    # the velocity of a joint that sticks is no free variable
    known = [name for i, name in enumerate(STATES) if i < 2 or modes[i - 2]] + INPUTS
    expected = differences(me, y, unknown, known)
    found = np.array([me.directional(unknown, [name], [1.0]) for name in known]).T
    np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-7 * max(1.0, np.abs(expected).max()))
    if nominal.fmi == 3:
        rng = np.random.default_rng(5)
        left = rng.normal(size=len(unknown))
        np.testing.assert_allclose(me.adjoint(unknown, known, left.tolist()), left @ found, rtol=1e-10, atol=1e-10)
    me.free()


def test_sliding_is_constant_between_events(nominal: Fmu) -> None:
    me, _ = placed(nominal, (1, 0))
    assert me.directional(["sliding[1]", "sliding[2]"], ["joint[1].dq"], [1.0]).tolist() == [0.0, 0.0]
    me.free()


@pytest.mark.parametrize(
    "parameter", ["joint[1].mass", "joint[2].com[1]", "joint[1].friction.C1", "dq_start[1]", "q_start[2]"]
)
def test_in_initialization(nominal: Fmu, parameter: str) -> None:
    """With respect to parameters and initial conditions, before the start."""
    start = {"dq_start[1]": 0.1, "dq_start[2]": -0.2, "q_start[2]": 0.8, "tau[1]": 0.5}
    unknown = OUT + RATES + STATES
    it = nominal.instance()
    it.put(start)
    it.enter()
    (value,) = it.get(parameter)
    expected, h = 0.0, 2e-4
    for factor, weight in ((1, 8), (-1, -8), (2, -1), (-2, 1)):
        it.put({parameter: value + factor * h})
        expected = expected + weight * it.get(*unknown) / (12.0 * h)
    it.put({parameter: value})
    found = it.directional(unknown, [parameter], [1.0])
    np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-7 * max(1.0, np.abs(expected).max()))
    if nominal.fmi == 3:
        left = np.random.default_rng(6).normal(size=len(unknown))
        np.testing.assert_allclose(
            it.adjoint(unknown, [parameter], left.tolist())[0], left @ found, rtol=1e-10, atol=1e-10
        )
    it.free()


@pytest.mark.parametrize("fmi", [pytest.param(2, marks=pytest.mark.slow), 3])  # 3 has adjoints besides
def test_a_delayed_input_is_none_of_the_present(made: Callable[[Arm, int], Path], fmi: int) -> None:
    """But it is while all begins, where it has always been there, and where the delay is tuned away."""
    it = Fmu(made(DELAYED, fmi)).instance()
    it.put({"tau[1]": 9.0, "tau[2]": 5.0, "effect.delay[2].time": 0.0})
    it.enter()
    begins = np.array([it.directional(RATES, [name], [1.0]) for name in INPUTS])
    assert it.call("ExitInitializationMode") == OK
    assert it.step(0.0, 1e-6) == OK
    found = np.array([it.directional(RATES, [name], [1.0]) for name in INPUTS])
    assert np.abs(begins).max(axis=1).min() > 1.0
    np.testing.assert_allclose(found, [0.0 * begins[0], begins[1]], rtol=1e-4, atol=1e-9)
    if fmi == 3:
        back = [it.adjoint(RATES, INPUTS, row) for row in np.eye(len(RATES)).tolist()]
        np.testing.assert_allclose(back, found.T, rtol=1e-12)
    it.free()


def test_output_derivatives(nominal: Fmu) -> None:
    """dq/dt = dq, and d(dq)/dt is the acceleration."""
    import ctypes

    cs = nominal.instance().begin({"dq_start[1]": 0.3, "dq_start[2]": -0.4, "tau[1]": 3.0})
    assert cs.step(0.0, 0.01) == OK
    names = ["q[1]", "q[2]", "dq[1]", "dq[2]"]
    out, orders = (ctypes.c_double * 4)(), (ctypes.c_int * 4)(1, 1, 1, 1)
    more = () if nominal.fmi == 2 else (ctypes.c_size_t(4),)
    status = cs.call("GetRealOutputDerivatives", cs._vrs(names), ctypes.c_size_t(4), orders, out, *more,
                     name3="GetOutputDerivatives")  # fmt: skip
    assert status == OK
    expected = cs.get("dq[1]", "dq[2]", "der(joint[1].dq)", "der(joint[2].dq)")
    np.testing.assert_allclose(np.array(out), expected, rtol=1e-12)
    cs.free()
