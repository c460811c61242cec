"""The tip of a chain and a force there: against complex numbers, virtual work and what a blow leaves of energy."""

import casadi as ca
import numpy as np
import pytest

from stribeck.arm import Arm, EffectEntry, Friction, Joint
from stribeck.model.tip import tip_of
from stribeck.model.values import Signals
from stribeck.simulate.engine import Engine, path_of

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


def test_a_wall_in_the_plane_gives_back_what_it_took() -> None:
    """Motion and spring hold one energy while an arm without friction, weights or motors strikes a wall."""
    smooth = Friction(0.0, 0.0, 0.0, 0.1)
    joints = tuple(
        Joint(name, "revolute", 0.4, 2.0, (0.2, 0.0), 0.03, 0.05, smooth, smooth) for name in ("upper", "fore")
    )
    wall = {"stiffness": 3000.0, "direction": 0.7, "distance": 0.6, "damping": 0.0}
    entry = EffectEntry("contact", ("upper",), {"upper": wall}, "plane_linear")
    engine = Engine(path_of(Arm("two links", (0.0, 0.0), joints, sample_time=0.001, effects=(entry,))))
    t = np.arange(0.0, 2.0, 0.001)
    start = engine.start(engine.p, np.array([-0.6, 0.3]))
    start[2:4] = 2.0, -1.0
    q, dq = (getattr(engine.run(engine.p, start, t, np.zeros((len(t), 2))), name) for name in ("q", "dq"))
    angle, turn = np.cumsum(q, axis=1), np.cumsum(dq, axis=1)
    elbow, fore, half = (
        length * np.exp(1j * a) for length, a in ((0.4, angle[:, 0]), (0.4, angle[:, 1]), (0.2, angle[:, 1]))
    )
    speeds = np.abs(elbow * turn[:, 0] / 2.0) ** 2 + np.abs(elbow * turn[:, 0] + half * turn[:, 1]) ** 2
    motion = speeds + 0.5 * (0.03 * turn**2 + 0.05 * dq**2).sum(axis=1)
    depth = np.maximum(((elbow + fore) * np.exp(-0.7j)).real - 0.6, 0.0)
    spring = 1500.0 * depth**2
    assert spring.max() > 0.3 * motion.max()
    assert motion + spring == pytest.approx(np.full_like(t, motion[0]), rel=2e-3)
