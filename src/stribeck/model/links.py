"""What moves the links of flexible joints, in terms of the deflection between motor and link."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca


@dataclass(frozen=True)
class Motors:
    """Positions, rad, and velocities, rad/s, of the motors of the L flexible joints, each (L, 1)."""

    position: Any
    velocity: Any

    @property
    def in_turn(self) -> Any:
        """Position and velocity of each motor in turn (2 L, 1), as links have them in a path's states."""
        pairs = zip(ca.vertsplit(self.position), ca.vertsplit(self.velocity), strict=True)
        return ca.vertcat(*[value for pair in pairs for value in pair])

    def deflections(self, states: Any) -> Any:
        """Return the deflections, then their rates (2 L, 1), of link states (2 L, 1)."""
        return ca.vertcat(self.position - states[0::2], self.velocity - states[1::2])

    def states(self, deflections: Any, of_motors: Any | None = None) -> Any:
        """Return link states (2 L, columns) from deflections and rates; of derivatives, the motors' are given."""
        count = self.position.numel()
        before = self.in_turn if of_motors is None else of_motors
        return before - ca.vertcat(*[deflections[i + k, :] for i in range(count) for k in (0, count)])


@dataclass(frozen=True)
class Links:
    """What moves the L links of the flexible joints, motor side taken as known.

    Attributes
    ----------
    free : (L, 1)
        Acceleration of the motors less that of the links if nothing were transmitted, rad/s^2.
    mobility : (L, L)
        Link acceleration by transmitted torque, 1/(kg m^2).
    resistance : (L, 2 L)
        What torque from outside grows by with the links' positions, N m/rad, then with their velocities, N m s/rad.
    """

    free: Any
    mobility: Any
    resistance: Any
