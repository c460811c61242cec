"""The inertia that joints move, and the balance of a joint without a drive, which holds at any scale."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.arm import Arm, Joint
from stribeck.identify.conditioning import condition
from stribeck.identify.inertia import MovedInertia
from stribeck.identify.residual import Residual
from stribeck.model.layout import values_of
from stribeck.model.path import SignalPath
from stribeck.run import Run

from .conftest import FRICTION, PENDULUM, sines

A = replace(PENDULUM, com=(0.2, 0.05))
B = Joint("B", "revolute", 0.3, 1.2, (0.15, -0.02), 0.02, 0.01, FRICTION, FRICTION)
TWO = Arm("two links", (9.81, 0.0), (A, B))
PATH = SignalPath(TWO)
P = values_of(PATH.entries)


def run(*torques: float) -> Run:
    """Two joints on sines that are not each other's, under torques of these sizes, N m: nothing that balances."""
    t = np.arange(1500) / 250.0
    q = np.column_stack([sines(t)[0], sines(t + 0.7, 0.8)[0]])
    return Run("two", t, q, np.array(torques) * np.sin(3.0 * t[:, None] + np.arange(2)))


def residual(*torques: float, columns: tuple[int, ...] | None = None) -> Residual:
    return Residual(PATH, [condition(TWO, run(*torques), 15.0, np.full(2, 1e-6), thin=True)], columns)


def scaled(factor: float) -> np.ndarray:
    """All masses, inertias and friction torques times a factor: lengths and speeds as they are."""
    whole = ("mass", "inertia", "rotor_inertia", "C0", "C1", "C2")
    return np.array([v * (factor if e.name in whole else 1.0) for e, v in zip(PATH.entries, P, strict=True)])


def test_inertia_of_two_links_in_closed_form() -> None:
    for bend in (0.0, 1.1, np.pi):
        reach = A.length**2 + 2.0 * A.length * (0.15 * np.cos(bend) + 0.02 * np.sin(bend)) + 0.15**2 + 0.02**2
        first = A.inertia + A.mass * (0.2**2 + 0.05**2) + B.inertia + B.mass * reach + A.rotor_inertia
        second = B.inertia + B.mass * (0.15**2 + 0.02**2) + B.rotor_inertia
        found = MovedInertia(PATH)(np.array([[0.4, bend]]), P)[0]
        assert found == pytest.approx([first, second], rel=1e-9)


@pytest.mark.parametrize("factor", [0.5, 1.3])
def test_a_joint_without_a_drive_leaves_the_same_at_any_scale(factor: float) -> None:
    free, nominal = residual(1.0, 0.0, columns=()), residual(1.0, 1.0, columns=())
    assert free.value(scaled(factor))[:, 1] == pytest.approx(free.value(P)[:, 1], rel=1e-9)
    assert free.value(P)[:, 0] == pytest.approx(nominal.value(P)[:, 0], rel=1e-12)
    driven = nominal.value(scaled(factor))[:, 1] - nominal.value(P)[:, 1]
    assert np.sqrt(np.mean(driven**2)) > 0.1 * np.std(nominal.value(P)[:, 1])


def test_its_derivatives_are_those_of_what_it_leaves() -> None:
    one = residual(1.0, 0.0)
    _, jacobian = one(P)
    for k, i in enumerate(one.columns):
        step = 1e-6 * max(abs(P[i]), 1e-2)
        ahead, behind = P.copy(), P.copy()
        ahead[i] += step
        behind[i] -= step
        expected = (one.value(ahead) - one.value(behind)) / (2.0 * step)
        assert jacobian[..., k] == pytest.approx(expected, abs=1e-4 * (np.abs(expected).max() + 1.0))
