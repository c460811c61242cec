"""The joint in which an effect is hidden, and what it is asked to do: the yardstick for the effect's strength."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stribeck.arm import Arm, Joint
from stribeck.withheld.excitation import needed_torque
from stribeck.withheld.motions import Motion
from stribeck.withheld.plant import Array, rigid_torque


@dataclass(frozen=True)
class Stage:
    """The joint that the effect sits in, and what it does in these motions.

    Attributes
    ----------
    joint : Joint
        The true joint.
    torque, peak : float
        rms torque that it needs, gravity apart, and its peak with gravity, N m.
    holding : float
        Torque that starts it against gravity, at most, N m.
    power, speed : float
        Mean friction power, W; peak speed, rad/s.
    angles : (N,) array
        Its angles in all motions, rad.
    tips : (N,) array or None
        The arm's tip in all motions, x + iy, m; None where a single joint moves it.
    inertia : float
        About its axis, the arm stretched, rotor apart, kg m^2.
    vertical : bool
        Whether the arm feels gravity.
    radian : float
        What stands for a radian in sizes as they are met at joints that turn: 1, on an axis that slides half the way
        that it is moved, m.
    rng : numpy.random.Generator
        Source of phases, harmonics and places.
    """

    joint: Joint
    torque: float
    peak: float
    holding: float
    power: float
    speed: float
    angles: Array
    tips: NDArray[np.complex128] | None
    inertia: float
    vertical: bool
    radian: float
    rng: np.random.Generator

    @property
    def break_away(self) -> float:
        """Break-away torque, N m."""
        return self.joint.friction.C0 + self.joint.friction.C1

    def phase(self) -> float:
        """Draw a phase, rad."""
        return float(self.rng.uniform(-math.pi, math.pi))

    def one_of(self, *values: float) -> float:
        """Draw one of the values."""
        return float(self.rng.choice(values))

    def between(self, low: float, high: float) -> float:
        """Draw a number."""
        return float(self.rng.uniform(low, high))

    def stiffest(self, twist: float, slowest: float) -> float:
        """Stiffness that gives way by `twist`, rad, under the rms torque, resonating no slower than `slowest`, Hz."""
        return max(self.torque / (twist * self.radian), self.inertia * (2.0 * math.pi * slowest) ** 2)


def stage_of(arm: Arm, k: int, motions: Sequence[Motion], rng: np.random.Generator) -> Stage:
    """Return what joint `k` of `arm` does along `motions`, as asked for."""
    joint, unit = arm.joints[k], np.eye(arm.n)[k : k + 1]
    parts = [motion.sample(np.arange(0.0, motion.duration, 0.005)) for motion in motions]
    q, dq, ddq = (np.concatenate([part[i] for part in parts]) for i in range(3))
    total = needed_torque(arm, q, dq, ddq)[:, k]
    gravity = rigid_torque(arm, q, 0.0 * q, 0.0 * q)[:, k]
    moving = total - gravity
    friction = total - rigid_torque(arm, q, dq, ddq)[:, k]
    zero = np.zeros((1, arm.n))
    inertia = float((rigid_torque(arm, zero, zero, unit) - rigid_torque(arm, zero, zero, zero))[0, k])
    return Stage(
        joint=joint,
        torque=float(np.sqrt(np.mean(moving**2))),
        peak=float(np.quantile(np.abs(total), 0.995)),
        holding=float(np.abs(gravity).max()) + joint.friction.C0 + joint.friction.C1,
        power=max(1e-9, float(np.mean(friction * dq[:, k]))),
        speed=max(1e-3, float(np.abs(dq[:, k]).max())),
        angles=q[:, k],
        tips=np.exp(1j * np.cumsum(q, axis=1)) @ [joint.length for joint in arm.joints] if arm.n > 1 else None,
        inertia=max(1e-9, inertia - joint.rotor_inertia),
        vertical=math.hypot(*arm.gravity) > 1.0,
        radian=1.0 if joint.kind == "revolute" else max(1e-6, 0.5 * float(np.ptp(q[:, k]))),
        rng=rng,
    )
