"""The tip of a chain and a force there: against complex numbers and against virtual work."""

import casadi as ca
import numpy as np
import pytest

from stribeck.model.tip import tip_of
from stribeck.model.values import Signals

LENGTH = np.array([0.5, 0.3, 0.2])


def test_tip_and_levers() -> None:
    rng = np.random.default_rng(0)
    q, dq, force = rng.normal(size=3), rng.normal(size=3), rng.normal(size=2)
    symbols = ca.SX.sym("q", 3)
    motion = [Signals(0.0, symbols[j], 0.0, 0.0, symbols[j], dq[j]) for j in range(3)]
    tip, levers = tip_of(tuple(LENGTH), motion)
    slope = ca.jacobian(ca.vertcat(tip.x, tip.y), symbols)
    torques = ca.vertcat(*[x * force[1] - y * force[0] for x, y in levers])
    results = [ca.vertcat(tip.x, tip.y), ca.vertcat(tip.dx, tip.dy), slope, torques]
    place, speed, jacobian, torque = (v.full().squeeze() for v in ca.Function("tip", [symbols], results)(q))
    end = np.sum(LENGTH * np.exp(1j * np.cumsum(q)))
    assert place == pytest.approx([end.real, end.imag])
    assert speed == pytest.approx(jacobian @ dq)
    assert torque == pytest.approx(jacobian.T @ force)
