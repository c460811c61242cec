"""What an effect declares and what its law is given: parameters, records, signals, the rigid body."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

Expression = Any
"""A CasADi expression (``casadi.SX``, scalar unless said otherwise) or a float."""

Parameters = Mapping[str, Expression]
States = Mapping[str, Expression]

STANDARD_GRAVITY = 9.81  # m/s^2
IN_TIME = "Hz"
OVER_POSITION = ("1/rad", "1/m")  # a rate is in 1/s, and no wave


@dataclass(frozen=True)
class Parameter:
    """One parameter of an effect.

    Attributes
    ----------
    name, unit, description : str
        As they appear in the arm file and in reports.
    null : float
        The value at which the effect vanishes; infinite where it vanishes in a limit (a stiffness).
    lower, upper : float
        Physical bounds. Both must be positive where ``log`` is set.
    log : bool
        Fitted in its logarithm: for positive values whose order of magnitude is unknown.
    firm : bool
        The lower bound is itself a likely value (once per turn): a fit that rests on it is no worse for that.
    reach : float
        Of a place of the joint, how far from the middle of its motion a fit looks for it: where an encoder has its zero
        says nothing. Infinite of all else.
    """

    name: str
    unit: str
    description: str
    null: float = 0.0
    lower: float = -math.inf
    upper: float = math.inf
    log: bool = False
    firm: bool = False
    reach: float = math.inf

    @property
    def place(self) -> bool:
        """Whether it is a place of the joint."""
        return math.isfinite(self.reach)

    def bounds(self, middle: float) -> tuple[float, float]:
        """Return the bounds of a fit to motions about a middle, rad; near the physical ones where it lies beyond."""
        near = min(max(middle, self.lower), self.upper)
        return max(self.lower, near - self.reach), min(self.upper, near + self.reach)

    @property
    def pitch(self) -> bool:
        """Whether it says how often a wave repeats, over position or in time."""
        return self.unit in (IN_TIME, *OVER_POSITION)


@dataclass(frozen=True)
class Record:
    """What was recorded of one joint: one entry a run, or a stretch of one between gaps.

    Attributes
    ----------
    position : tuple of array (N,)
        rad, uniform in time.
    velocity : tuple of array (N,)
        rad/s, as the drive gave it; empty where no run has it.
    sample_time : tuple of float
        s.
    resolution : float or None
        Of the encoder, as the arm file has it, rad.
    read : tuple of array (N,)
        Positions as the encoder gave them, rad, at whatever times; empty where these are uniform.
    prismatic : bool
        Whether the joint is an axis in m.
    """

    position: tuple[np.ndarray, ...]
    velocity: tuple[np.ndarray, ...]
    sample_time: tuple[float, ...]
    resolution: float | None
    read: tuple[np.ndarray, ...] = ()
    prismatic: bool = False


@dataclass(frozen=True)
class Observed:
    """What records show of an effect without a model: value and 95 % interval of each parameter, and the evidence."""

    values: Mapping[str, tuple[float, float, float]]
    probability: float


@dataclass(frozen=True)
class Signals:
    """What a law may depend on at one joint and one instant (CasADi scalars, SI).

    ``position``, ``velocity``, ``acceleration`` are true ones on the motor side; ``link_position`` and
    ``link_velocity`` those of the link; ``torque`` is the actuator's, ``load`` the torque handed to the link,
    ``weight`` the part of it that gravity asks for (where a law uses it), ``viscous`` the friction that has no sign
    function, for laws of the sliding level, ``friction`` the size of all of it while the joint slides (where a law uses
    it), N m. As for the past: ``recordings`` were made before, of ``recorded`` s
    together, in which the joint had gone ``travelled``. This one had lasted for ``lead`` s before what is here of it,
    and the joint gone ``led``. A simulation has no past. Of a recorded motion the part ``sliding`` is surely no noise.
    """

    time: Expression
    position: Expression
    velocity: Expression
    acceleration: Expression
    link_position: Expression
    link_velocity: Expression
    torque: Expression = 0.0
    load: Expression = 0.0
    weight: Expression = 0.0
    viscous: Expression = 0.0
    friction: Expression = 0.0
    sliding: Expression = 1.0
    recordings: Expression = 0.0
    recorded: Expression = 0.0
    travelled: Expression = 0.0
    lead: Expression = 0.0
    led: Expression = 0.0

    @property
    def slide(self) -> Expression:
        """The speed, rad/s, for laws in the distance gone: of noise at rest there would be no end."""
        return self.sliding * abs(self.velocity)

    def at(self, **changes: Expression) -> Signals:
        """Return a copy with some signals replaced."""
        return replace(self, **changes)


@dataclass(frozen=True)
class Body:
    """Inertial parameters of a planar chain, each a tuple over joints, and gravity in the base frame."""

    mass: tuple[Expression, ...]
    com_x: tuple[Expression, ...]
    com_y: tuple[Expression, ...]
    inertia: tuple[Expression, ...]
    length: tuple[Expression, ...]
    gravity: tuple[Expression, Expression]

    def with_link(self, joint: int, **values: Expression) -> Body:
        """Return a copy with values of one link replaced (``mass``, ``com_x``, ``com_y``, ``inertia``)."""
        changed = {name: _put(getattr(self, name), joint, value) for name, value in values.items()}
        return replace(self, **changed)


@dataclass(frozen=True)
class Tip:
    """The end of a chain's last link in the base frame: position, m, and velocity, m/s."""

    x: Expression
    y: Expression
    dx: Expression
    dy: Expression


def _put(values: tuple[Expression, ...], index: int, value: Expression) -> tuple[Expression, ...]:
    return (*values[:index], value, *values[index + 1 :])
