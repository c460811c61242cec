"""What an effect declares and what its law is given: parameters, records, signals, the rigid body."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

Expression = Any
"""A CasADi expression (``casadi.SX``, scalar unless said otherwise) or a float."""

PROMPT = 1.6e-3
"""Lateness that any drive or record has, s: current loops of 100 Hz and more, a sample of a fast digital loop."""

GIVES = 2e-5
"""Way by which any contact gives before it slides, m: rolling elements and teeth do so by some ten micrometres."""

ARM_OF_CONTACT = 0.05
"""Radius at which the contacts of a joint that turns lie, m: of its bearings and gears."""

RENEWS = 0.005
"""Slide that renews any contact, m: what takes longer is the grease's structure, not the contact's age."""

STRAY = 0.015
"""Part of its torque by which any drive or gear strays: offsets, slots, ripples, sides that are not quite alike."""

UNEVEN = 0.02
"""Part of its friction by which any joint's varies along its way."""

LIGHTEST = 0.01
"""Least part of a joint's inertia that is taken to lie beyond its transmission."""

MOST_A_TURN = 240.0
"""Cycles a turn that are looked for: magnets on slots, and the two a turn of a wave generator behind 100:1."""

MOST_PERIODS = 60.0
"""Periods over the travel that are looked for on an axis in m: a screw or a magnet track may have as many."""

LEAST_OF_PERIOD = 1.0
"""Part of a period that must be covered: less is any curve over position, a stiffening spring, an offset and cables."""

LEAST_DRIVE = 0.4
"""Part of the torque that a motion needs (root mean square): a drive with a lower limit would hardly drive."""

Parameters = Mapping[str, Expression]
States = Mapping[str, Expression]


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
    """

    name: str
    unit: str
    description: str
    null: float = 0.0
    lower: float = -math.inf
    upper: float = math.inf
    log: bool = False
    firm: bool = False

    @property
    def pitch(self) -> bool:
        """Whether it says how often a wave repeats, over position or in time."""
        return self.unit == "Hz" or self.unit.startswith("1/")


@dataclass(frozen=True)
class Scale:
    """Typical magnitudes of one joint in the data at hand, from which an effect takes its starting values.

    Attributes
    ----------
    torque, needed, friction : float
        Root mean square command, and torque that the nominal arm needs for the motion, and Coulomb friction, N m.
    speed : float
        Root mean square velocity, rad/s.
    travel, covered, middle : float
        Range of position in the run that goes furthest, and in all together, and its median, rad.
    distance : float
        That the joint goes to and fro in all recordings together, rad.
    inertia, rotor : float
        Inertia that the joint moves, others held, and its rotor's part of that, kg m^2.
    sample_time : float
        Of the recordings, s.
    prismatic : bool
        Whether the joint is an axis in m: no turn says then how often what is periodic repeats.
    """

    torque: float
    friction: float
    speed: float
    travel: float
    inertia: float
    sample_time: float
    length: float = 1.0
    middle: float = 0.0
    prismatic: bool = False
    distance: float = math.inf
    rotor: float = 0.0
    covered: float = 0.0
    needed: float = math.inf

    def may_limit(self, torque: float) -> bool:
        """Return whether a drive that gives no more than a torque, N m, drives the motion.

        A controller whose drive is at its limit asks for ever more: its command alone would be no measure.
        """
        return torque > LEAST_DRIVE * min(self.torque, self.needed)

    def rates(self, most: float = MOST_A_TURN) -> tuple[float, float]:
        """Return the range of cycles per radian of phase, 1/rad, in which a periodic law may start.

        From one to ``most`` a turn; on an axis in m from half a period over the travel to MOST_PERIODS of them.
        """
        return (math.pi / self.travel, 2.0 * math.pi * MOST_PERIODS / self.travel) if self.prismatic else (1.0, most)

    def furthest(self, position: float) -> float:
        """Return how far the joint goes from a position, rad, in a run about its median."""
        return abs(self.middle - position) + 0.5 * self.travel

    @property
    def link(self) -> float:
        """Inertia that is moved through the transmission, kg m^2: all but the rotor's, which may be most of it."""
        return max(self.inertia - self.rotor, LIGHTEST * self.inertia)

    def shows(self, harmonic: float) -> bool:
        """Return whether enough of a period (``harmonic`` a radian) is covered to be more than any curve."""
        return harmonic * max(self.travel, self.covered) > LEAST_OF_PERIOD * 2.0 * math.pi

    @property
    def stray(self) -> float:
        """Torque by which any drive or gear strays, N m."""
        return STRAY * self.torque

    @property
    def gives(self) -> float:
        """Way by which any contact gives before it slides, rad: GIVES, for a joint that turns at ARM_OF_CONTACT."""
        return GIVES if self.prismatic else GIVES / ARM_OF_CONTACT

    @property
    def renews(self) -> float:
        """Slide that renews any contact, rad: RENEWS, for a joint that turns at ARM_OF_CONTACT."""
        return RENEWS if self.prismatic else RENEWS / ARM_OF_CONTACT


@dataclass(frozen=True)
class Record:
    """What was recorded of one joint: one entry a run, uniform in time.

    Attributes
    ----------
    position : tuple of array (N,)
        rad, as the encoder gave it.
    velocity : tuple of array (N,)
        rad/s, as the drive gave it; empty where no run has it.
    sample_time : tuple of float
        s.
    resolution : float or None
        Of the encoder, as the arm file has it, rad.
    """

    position: tuple[np.ndarray, ...]
    velocity: tuple[np.ndarray, ...]
    sample_time: tuple[float, ...]
    resolution: float | None


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
    function, for laws of the sliding level. As for the past: ``recordings`` were made before, of ``recorded`` s
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
