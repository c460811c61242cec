"""Arms of every size, and what a file says about them when its author had only a data sheet."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from stribeck.arm import Arm, Friction, Joint, Tolerance

GRAVITY = 9.81  # m/s^2
SMALLEST, LARGEST = 0.3, 200.0  # N m, peak torque of the first joint: quasi-direct-drive pendulum to direct-drive arm


def random_arm(rng: np.random.Generator, n_joints: int = 2, vertical: bool = False) -> Arm:
    """Return a true arm of realistic size, without any effect beyond Tustin friction.

    The peak torque of the first joint is drawn between 0.3 and 200 N m on a log scale; sizes and masses follow from it
    so that an outstretched arm takes about a quarter of it against gravity, friction takes 2 to 8 %.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of everything random.
    n_joints : int
        1 to 4.
    vertical : bool
        Whether gravity acts in the arm's plane (measured from the downward vertical).
    """
    torque = _log(rng, SMALLEST, LARGEST)
    joints = []
    for k in range(n_joints):
        joints.append(_joint(rng, "ABCD"[k], torque, n_joints))
        torque *= rng.uniform(0.3, 0.55)
    name = f"{'vertical' if vertical else 'horizontal'} arm with {n_joints} joint{'s' if n_joints > 1 else ''}"
    return Arm(name, (GRAVITY, 0.0) if vertical else (0.0, 0.0), tuple(joints))


def _joint(rng: np.random.Generator, name: str, torque: float, n_joints: int) -> Joint:
    length = 0.14 * (torque / SMALLEST) ** 0.2 * rng.uniform(0.8, 1.25)
    crowd = 1.0 / (1.0 + 0.4 * max(0, n_joints - 2))  # a long chain has to be lighter
    mass = 0.25 * crowd * torque / (GRAVITY * length) * rng.uniform(0.7, 1.3)
    centre = rng.uniform(0.35, 0.65) * length
    inertia = mass * length**2 / 12.0 * rng.uniform(0.7, 1.3)
    rotor = (inertia + mass * centre**2) * _log(rng, 0.15, 1.2)
    friction = _friction(rng, torque)
    com = (_round(centre), _round(length * rng.normal(0.0, 0.02)))
    return Joint(
        name, "revolute", _round(length), _round(mass), com, _round(inertia), _round(rotor), friction, friction,
        torque_limit=_round(torque),
    )  # fmt: skip


def _friction(rng: np.random.Generator, torque: float) -> Friction:
    """Constants that bend downwards at low speed: C2 alpha < C1."""
    coulomb = torque * _log(rng, 0.02, 0.08)
    stribeck, viscous = coulomb * rng.uniform(0.12, 0.45), coulomb * _log(rng, 0.1, 0.5)
    return Friction(_round(coulomb), _round(stribeck), _round(viscous), _round(_log(rng, 0.02, 0.12)))


MOST_OFF = 0.3  # relative standard deviation of a value with a tolerance of its own, however large that is


def misinformed(
    arm: Arm, rng: np.random.Generator, inertial: float = 0.1, friction: float = 0.2, tolerance: bool = True
) -> Arm:
    """Return the nominal arm: masses, centres, inertias and Tustin constants off by relative errors.

    Parameters
    ----------
    arm : Arm
        The true arm; lengths, limits and encoders are known exactly.
    rng : numpy.random.Generator
        Source of the errors.
    inertial, friction : float
        Relative standard deviations of values that have no tolerance of their own; no value is off by more than two of
        them. Friction stays as symmetric as it was.
    tolerance : bool
        Whether the arm states these errors as its tolerance.
    """

    def off(value: float, size: float) -> float:
        return _round(value * math.exp(size * float(np.clip(rng.standard_normal(), -2.0, 2.0))))

    def joint(true: Joint) -> Joint:
        def size(name: str, value: float, usual: float) -> float:
            known = name not in true.tolerance or value == 0.0
            return usual if known else min(true.tolerance[name] / abs(value), MOST_OFF)

        errors = {n: off(1.0, size(n, getattr(true.friction, n), friction)) for n in ("C0", "C1", "C2", "alpha")}
        forward, backward = (
            Friction(**{name: _round(getattr(side, name) * error) for name, error in errors.items()})
            for side in (true.friction, true.backward)
        )
        return replace(
            true,
            mass=off(true.mass, size("mass", true.mass, inertial)),
            com=(
                off(true.com[0], size("com_x", true.com[0], inertial)),
                off(true.com[1], size("com_y", true.com[1], inertial)),
            ),
            inertia=off(true.inertia, size("inertia", true.inertia, inertial)),
            rotor_inertia=off(true.rotor_inertia, size("rotor_inertia", true.rotor_inertia, inertial)),
            friction=forward,
            backward=backward,
        )

    stated = Tolerance(max(inertial, 1e-6), max(friction, 1e-6)) if tolerance else arm.tolerance
    return replace(arm, joints=tuple(joint(j) for j in arm.joints), tolerance=stated)


def _log(rng: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(math.log(low), math.log(high))))


def _round(value: float) -> float:
    return float(f"{value:.4g}")
