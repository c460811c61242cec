"""The arm as frozen values, with the bounds that each number must keep.

A planar serial chain of revolute joints, base to tip, or one prismatic axis. All numbers are SI; for a prismatic
axis rad becomes m, N m becomes N and kg m^2 becomes kg.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Literal

from pydantic import AfterValidator, ConfigDict, Field

BESIDE = 0.01  # of a link's length, by which centres of mass lie beside the lines on which drawings have them

Finite = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0)]
NotNegative = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0)]
Relative = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, le=10)]


def _writable(text: str) -> str:
    """Return a name that any file can hold: XML has no control characters, nor what is no character at all."""
    odd = [c for c in text if unicodedata.category(c) in ("Cc", "Cn", "Cs")]
    if odd:
        raise ValueError(f"a name cannot have the character U+{ord(odd[0]):04X}")
    return text


Name = Annotated[str, Field(min_length=1, max_length=100), AfterValidator(_writable)]

_STRICT = ConfigDict(extra="forbid")


@dataclass(frozen=True)
class Friction:
    """Tustin friction ``C0 + C1 exp(-|dq|/alpha) + C2 |dq|``, opposing the motion.

    Tustin (1947), eq. (1) of Popovic, Goldenberg, Shimoga and Hui. Units: `C0`, `C1` N m; `C2` N m s/rad;
    `alpha` rad/s.
    """

    __pydantic_config__ = _STRICT

    C0: NotNegative
    C1: NotNegative
    C2: NotNegative
    alpha: Positive


@dataclass(frozen=True)
class Joint:
    """One joint and the link that it moves.

    Attributes
    ----------
    name, kind : str
        ``kind`` is ``"revolute"`` or ``"prismatic"``: nothing then depends on length, com and inertia, and a file may
        leave them out.
    length : float
        From this joint's axis to the next (last joint: to the tip), m.
    mass : float
        kg.
    com : tuple of 2 floats
        Centre of mass in the link frame (x along the link), m.
    inertia, rotor_inertia : float
        About the centre of mass, and of the rotor reflected to the joint, kg m^2.
    friction, backward : Friction
        Constants for dq > 0 and for dq < 0; equal where friction is symmetric.
    torque_limit : float or None
        N m.
    encoder_resolution : float or None
        rad.
    tolerance : mapping
        Standard deviation of single values, in their own units, instead of the arm's relative one.
    """

    __pydantic_config__ = _STRICT

    name: Name
    kind: Literal["revolute", "prismatic"]
    length: NotNegative
    mass: Positive
    com: tuple[Finite, Finite]
    inertia: NotNegative
    rotor_inertia: NotNegative
    friction: Friction
    backward: Friction
    torque_limit: Positive | None = None
    encoder_resolution: NotNegative | None = None
    tolerance: Mapping[str, NotNegative] = field(default_factory=dict, hash=False)


@dataclass(frozen=True)
class Tolerance:
    """How well the nominal values are known: relative, one standard deviation.

    At most 10: what is not known within ten times its value is not known at all, and re-tuning takes in any gap.
    """

    __pydantic_config__ = _STRICT

    inertial: Relative = 0.1
    friction: Relative = 1.0


@dataclass(frozen=True)
class EffectEntry:
    """An effect beyond the nominal model: its name, its joints, joint -> parameter -> value (SI), and the law.

    Where a name stands for several laws and none is given, it is the first of the registry.
    """

    __pydantic_config__ = _STRICT

    effect: Name
    joints: Annotated[tuple[Name, ...], Field(min_length=1)]
    parameters: Mapping[str, Mapping[str, Finite]] = field(default_factory=dict)
    law: Name | None = None


@dataclass(frozen=True)
class Arm:
    """An arm: `gravity` in the arm's plane and base frame, m/s^2; `sample_time` of the controller, s."""

    __pydantic_config__ = _STRICT

    name: Name
    gravity: tuple[Finite, Finite]
    joints: Annotated[tuple[Joint, ...], Field(min_length=1)]
    sample_time: Positive | None = None
    tolerance: Tolerance = Tolerance()
    effects: tuple[EffectEntry, ...] = ()

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.joints)

    @property
    def names(self) -> tuple[str, ...]:
        """Joint names, base to tip."""
        return tuple(joint.name for joint in self.joints)

    @property
    def kinds(self) -> tuple[str, ...]:
        """``revolute`` or ``prismatic``, of each joint, base to tip."""
        return tuple(joint.kind for joint in self.joints)

    def deviation(self, joint: int, name: str, value: float) -> float:
        """Return how well an inertial value of a joint is known: one standard deviation, in the value's own unit."""
        stated = self.joints[joint].tolerance
        if name in stated:
            return stated[name]
        on_the_line = name == "com_y" and value == 0.0
        return self.beside_the_line(joint) if on_the_line else self.tolerance.inertial * abs(value)

    def beside_the_line(self, joint: int) -> float:
        """Return how well it is known that a centre of mass lies on its link's line, one standard deviation, m.

        A part of zero would be zero. Of the last link it is held: what lies beside the line there looks as an encoder
        offset does, which is an effect; of a first link that no weight turns it is not felt.
        """
        link, felt = self.joints[joint], joint > 0 or any(self.gravity)
        if joint == self.n - 1 or not felt:
            return 0.0
        return min(BESIDE * link.length, self.tolerance.inertial * abs(link.com[0]))
