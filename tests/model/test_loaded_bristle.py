"""A bristle whose level grows with the load: the equations of motion balance in every mode, and can be simulated."""

from dataclasses import replace
from itertools import product

import casadi as ca
import numpy as np
import pytest

from stribeck.arm import Arm, EffectEntry, Friction, Joint
from stribeck.model.forward import Forward
from stribeck.simulate import Engine, path_of

LAWS = list(product(("lugre", "maxwell_slip", "elasto_plastic"), ("proportional", "directional")))


def arm(n: int, bristle: str, load: str) -> Arm:
    """The first joint has the bristle; all have the load."""
    friction, backward = Friction(2.0, 0.5, 0.3, 0.05), Friction(1.7, 0.4, 0.2, 0.07)
    joints = tuple(
        Joint(f"J{j}", "revolute", 0.4, 3.0 - j, (0.2, 0.05), 0.05, 0.1, friction, backward) for j in range(n)
    )
    names = tuple(joint.name for joint in joints)
    first = EffectEntry("presliding", names[:1], {names[0]: {"stiffness": 1500.0, "damping": 5.0}}, bristle)
    every = EffectEntry("load_dependent_friction", names, {name: {"ratio": 0.1} for name in names}, load)
    return replace(Arm("test", (3.0, -5.0), joints), effects=(first, every))


@pytest.mark.parametrize(("bristle", "load"), LAWS)
def test_the_equations_of_motion_balance_in_every_mode(bristle: str, load: str) -> None:
    forward = Forward(path_of(arm(2, bristle, load)))
    d, n = forward._dynamics, 2
    path, m = d.path, d.motion
    left = [
        d.slides(j) * (d.signals[j].torque - m.load[j] - path.rotor(j) * m.motor[j] - m.friction[j]) for j in range(n)
    ]
    law = [m.friction[0] - path.viscous(0, d.signals[0], path.x) - d._dry(0, m.loading[0])]
    balance = ca.Function("balance", forward.inputs, [ca.vertcat(*left, *law)])
    p, rng = Engine(path).p, np.random.default_rng(0)
    for _ in range(200):
        velocity = rng.uniform(-3.0, 3.0, n) * 10 ** rng.uniform(-3.0, 0.0, n)
        velocity[1] *= rng.random() > 0.3
        bristles = rng.uniform(-3.0, 3.0, forward.size - 2 * n) / (forward.size - 2 * n)
        y = np.r_[rng.uniform(-3.0, 3.0, n), velocity, bristles]
        unbalanced = balance(0.0, y, np.sign(velocity), rng.uniform(-30.0, 30.0, n), p).full()
        assert np.abs(unbalanced).max() < 1e-9 * 30.0


@pytest.mark.parametrize(("bristle", "load"), LAWS)
@pytest.mark.parametrize("n", [1, 2])
@pytest.mark.long
def test_it_can_be_simulated_to_the_end(n: int, bristle: str, load: str) -> None:
    engine, t = Engine(path_of(arm(n, bristle, load))), np.arange(0.0, 2.0, 0.01)
    push = 8.0 * np.sin(2.0 * np.pi * 0.7 * t) + 4.0 * np.sin(2.0 * np.pi * 1.9 * t) + 3.0
    u = np.tile(push[:, None], (1, n)) * np.array([1.0, 0.3])[:n]
    found = engine.run(engine.p, engine.start(engine.p, np.full(n, 0.3), command=u[0]), t, u, tolerance=1e-8)
    assert found.status == "ok"
