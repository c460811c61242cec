"""Bases: what is too light or too damped is none; one that slides keeps the energy and momentum of the whole."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from stribeck.arm import Arm, Friction, Joint
from stribeck.effects.registry import effect_named, registry
from stribeck.effects.rigid_body.base_flexibility import DAMPED, LIGHTEST
from stribeck.model.forward import Forward
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath
from stribeck.model.scale import Scale

SCALE = Scale(torque=5.0, friction=0.5, speed=1.0, travel=2.0, inertia=0.4, sample_time=0.005, length=0.3)


def test_a_base_as_heavy_as_the_arm_can_be_meant_and_a_light_one_not() -> None:
    base, values = registry()["base_flexibility"], {"stiffness": 300.0, "damping": 1.0}
    assert base.plausible({**values, "inertia": SCALE.inertia}, SCALE)
    assert not base.plausible({**values, "inertia": 0.5 * LIGHTEST * SCALE.inertia}, SCALE)
    geared = replace(SCALE, rotor=0.6 * SCALE.inertia)  # which turns fast, and weighs little on the base
    assert base.plausible({**values, "inertia": 0.5 * LIGHTEST * SCALE.inertia}, geared)


def test_what_hardly_rings_is_no_stand() -> None:
    """A shaft's ringing that noise blurs would pass for one."""
    base, values = registry()["base_flexibility"], {"stiffness": 300.0, "inertia": 3.0}
    scale = Scale(torque=1.0, friction=0.1, speed=1.0, travel=1.0, inertia=1.0, sample_time=1e-3, length=0.5)
    critical = 60.0  # N m s/rad
    assert base.plausible({**values, "damping": 0.9 * DAMPED * critical}, scale)
    assert not base.plausible({**values, "damping": 1.1 * DAMPED * critical}, scale)


@pytest.mark.parametrize(("mass", "damping"), [(0.5 * LIGHTEST, 1.0), (2.0, 2.0 * DAMPED * 120.0)])
def test_a_light_or_a_slow_slide_is_no_stand(mass: float, damping: float) -> None:
    """The arm counts as a mass at its first link's end, here 1 kg; critical at 3 kg and 1200 N/m is 120 N s/m."""
    sliding, values = effect_named("base_flexibility", "sliding"), {"stiffness": 1200.0, "direction": 0.3}
    scale = Scale(torque=1.0, friction=0.1, speed=1.0, travel=1.0, inertia=0.25, sample_time=1e-3, length=0.5)
    assert sliding.plausible({**values, "mass": 2.0, "damping": 1.0}, scale)
    assert not sliding.plausible({**values, "mass": mass, "damping": damping}, scale)


LENGTH, MASS, COM, INERTIA = np.array([0.5, 0.3, 0.2]), np.array([4.0, 2.0, 1.0]), 0.6, 0.05


def chain(n: int) -> Arm:
    """Links without friction or rotors, in the horizontal plane."""
    smooth = Friction(0.0, 0.0, 0.0, 0.1)
    joints = tuple(
        Joint("ABC"[k], "revolute", LENGTH[k], MASS[k], (COM * LENGTH[k], 0.0), INERTIA, 0.0, smooth, smooth)
        for k in range(n)
    )
    return Arm("chain", (0.0, 0.0), joints, sample_time=1e-3)


def moving(n: int, y: np.ndarray, way: complex, turn: float) -> tuple[np.ndarray, np.ndarray]:
    """Velocities of the centres of mass (n, N), m/s in the complex plane, and of the links' turning, rad/s."""
    angle = np.cumsum(y[:n], axis=0) + turn * y[2 * n]
    omega = np.cumsum(y[n : 2 * n], axis=0) + turn * y[2 * n + 1]
    axis = np.broadcast_to(y[2 * n + 1] * way, angle[0].shape).astype(complex)
    speeds = []
    for k in range(n):
        turning = 1j * omega[k] * LENGTH[k] * np.exp(1j * angle[k])
        speeds.append(axis + COM * turning)
        axis = axis + turning
    return np.array(speeds), omega


@pytest.mark.parametrize("n", [1, 2, 3])
@pytest.mark.parametrize(("stiffness", "turn"), [(1e-4, 0.0), (900.0, 0.0), (900.0, -1.5), (900.0, 3.0)])
def test_energy_and_momentum_of_an_arm_on_a_base_that_slides(n: int, stiffness: float, turn: float) -> None:
    """Kinetic and spring energy stay; on a spring of next to nothing so does the momentum along the way."""
    values = {"stiffness": stiffness, "damping": 1e-6, "mass": 3.0, "direction": 0.7, "turn": turn}
    forward = Forward(path := SignalPath(chain(n), [Placed(effect_named("base_flexibility", "sliding"), 0, values)]))
    p, modes, still = values_of(path.entries), np.ones(n), np.zeros(n)

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        return np.asarray(forward.flow(t, y, modes, still, p)[0]).ravel()

    start = np.concatenate([np.linspace(0.2, 0.6, n), np.linspace(3.0, 1.0, n), [0.02, 0.1]])
    y = solve_ivp(rates, (0.0, 2.0), start, rtol=1e-9, atol=1e-10, t_eval=np.linspace(0.0, 2.0, 50)).y
    way = np.exp(0.7j)
    speeds, omega = moving(n, y, way, turn)
    kinetic = 0.5 * MASS[:n] @ np.abs(speeds) ** 2 + 0.5 * INERTIA * np.sum(omega**2, axis=0)
    energy = kinetic + 0.5 * 3.0 * y[2 * n + 1] ** 2 + 0.5 * stiffness * y[2 * n] ** 2
    momentum = MASS[:n] @ (speeds * way.conjugate()).real + 3.0 * y[2 * n + 1]
    assert np.ptp(y[2 * n]) > 0.02
    assert energy == pytest.approx(energy[0], rel=1e-4)
    assert stiffness > 1.0 or momentum == pytest.approx(momentum[0], rel=1e-3)
