"""What re-tuning a nominal arm takes up of a torque that it does not explain, and what it leaves.

A wrong value is no unmodelled effect: a payload within the tolerance of the last link's mass, a drive gain that all
inertias together can stand for, or a small tilt leave little behind once masses, centres, inertias and Tustin's
constants are re-tuned. The tangent of the unexplained torque in these values is taken from the recording plant's own
inverse dynamics, by differences; on it the torque is fitted maximum a posteriori (a ridge regression in units of the
stated tolerances), no value further from nominal than three of them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from scipy.optimize import lsq_linear

from stribeck.arm import Arm, Joint
from stribeck.withheld.plant import Array

LIMIT = 3.0  # standard deviations; beyond them a value is a gap of its own
STEP = 1e-3  # standard deviations, of the differences
_FRICTION = ("C0", "C1", "C2", "alpha")
_INERTIAL: dict[str, Callable[[Joint], float]] = {
    "mass": lambda joint: joint.mass,
    "com_x": lambda joint: joint.com[0],
    "com_y": lambda joint: joint.com[1],
    "inertia": lambda joint: joint.inertia,
    "rotor_inertia": lambda joint: joint.rotor_inertia,
}
Unexplained: TypeAlias = Callable[[Arm], Array]


@dataclass(frozen=True)
class Knob:
    """A nominal value that re-tuning may turn.

    Attributes
    ----------
    joint : int
    name : str
        Of the value.
    sides : tuple of str
        ``friction`` and ``backward``, or one of them; empty for an inertial value.
    sd : float
        How well it is known, one standard deviation, SI.
    off : float
        True less nominal value, in standard deviations.
    lower, upper : float
        How far re-tuning may turn it from nominal, in standard deviations.
    """

    joint: int
    name: str
    sides: tuple[str, ...]
    sd: float
    off: float
    lower: float
    upper: float

    def turned(self, arm: Arm, by: float) -> Arm:
        """Return the arm with this value larger by so many standard deviations."""
        joint, change = arm.joints[self.joint], by * self.sd
        if self.sides:
            constants = {side: getattr(joint, side) for side in self.sides}
            values = {s: replace(c, **{self.name: getattr(c, self.name) + change}) for s, c in constants.items()}
        elif self.name.startswith("com"):
            x, y = joint.com
            values = {"com": (x + change, y) if self.name == "com_x" else (x, y + change)}
        else:
            values = {self.name: _INERTIAL[self.name](joint) + change}
        joints = list(arm.joints)
        joints[self.joint] = replace(joint, **values)
        return replace(arm, joints=tuple(joints))


def knobs(nominal: Arm, true: Arm) -> tuple[Knob, ...]:
    """Return what may be re-tuned: every value that has a tolerance; friction stays as symmetric as nominal.

    Parameters
    ----------
    nominal : Arm
        With the tolerances that it states.
    true : Arm
        The same chain as it is.
    """
    found = []
    for k, (stated, real) in enumerate(zip(nominal.joints, true.joints, strict=True)):
        for name, get in _INERTIAL.items():
            found.append(_knob(k, name, (), nominal.deviation(k, name, get(stated)), get(stated), get(real)))
        tied = stated.friction == stated.backward
        for side in ("friction",) if tied else ("friction", "backward"):
            for name in _FRICTION:
                value, truth = (getattr(getattr(joint, side), name) for joint in (stated, real))
                meaningless = name == "alpha" and getattr(stated, side).C1 == 0.0
                sd = stated.tolerance.get(name, nominal.tolerance.friction * abs(value))
                sides = ("friction", "backward") if tied else (side,)
                found.append(_knob(k, name, sides, 0.0 if meaningless else sd, value, truth))
    return tuple(knob for knob in found if knob.sd > 0.0)


def _knob(k: int, name: str, sides: tuple[str, ...], sd: float, value: float, truth: float) -> Knob:
    off = (truth - value) / sd if sd > 0.0 else 0.0
    least = -LIMIT if name.startswith("com") else max(-LIMIT, -abs(value) / sd if sd > 0.0 else 0.0)
    return Knob(k, name, sides, sd, off, min(least, off), max(LIMIT, off))


def left_over(turnable: Sequence[Knob], arm: Arm, unexplained: Unexplained, weight: Array) -> Array:
    """Return what is left (M, n) of the unexplained torque after re-tuning, N m.

    Parameters
    ----------
    turnable : sequence of Knob
        See `knobs`.
    arm : Arm
        The true arm without the effect, where the tangent is taken.
    unexplained : callable
        Arm to the torque (M, n) that it leaves unexplained, N m.
    weight : array (M, n)
        Information of each sample, 1 / (N m)^2, against which the tolerances weigh.

    Notes
    -----
    With z the turns from nominal in standard deviations and z0 the true values, minimises
    sum_ik w_ik (r_ik + J_ik (z - z0))^2 + |z|^2 within the knobs' bounds.
    """
    here = unexplained(arm)
    slopes = np.stack([(unexplained(knob.turned(arm, STEP)) - here) / STEP for knob in turnable], axis=2)
    off = np.array([knob.off for knob in turnable])
    start = here - slopes @ off  # of the nominal arm
    root = np.sqrt(weight)
    rows = np.concatenate([(slopes * root[:, :, None]).reshape(-1, len(off)), np.eye(len(off))])
    wanted = -np.concatenate([(start * root).ravel(), np.zeros(len(off))])
    q, r = np.linalg.qr(rows)  # squared, rows of a quiet joint would outweigh the tolerances beyond all digits
    bounds = (np.array([knob.lower for knob in turnable]), np.array([knob.upper for knob in turnable]))
    z = lsq_linear(r, q.T @ wanted, bounds, method="bvls").x
    return np.asarray(start + slopes @ z)
