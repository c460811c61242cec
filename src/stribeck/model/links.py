"""What moves the links of flexible joints, in terms of the deflection between motor and link."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca


@dataclass(frozen=True)
class Links:
    """What moves the L links of the flexible joints, motor side taken as known.

    Attributes
    ----------
    position, velocity : (L, 1)
        Of the motors, rad and rad/s.
    free : (L, 1)
        Acceleration of the motors less that of the links if nothing were transmitted, rad/s^2.
    mobility : (L, L)
        Link acceleration by transmitted torque, 1/(kg m^2).
    resistance : (2 L, 1)
        What torque from outside grows by with the links' positions, N m/rad, then with their velocities, N m s/rad.
    """

    position: Any
    velocity: Any
    free: Any
    mobility: Any
    resistance: Any

    @property
    def motors(self) -> Any:
        """Position and velocity of each motor in turn (2 L, 1), as links have them in a path's states."""
        return _in_turn(self.position, self.velocity)

    def deflections(self, states: Any) -> Any:
        """Return the deflections, then their rates (2 L, 1), of link states (2 L, 1)."""
        return ca.vertcat(self.position - states[0::2], self.velocity - states[1::2])

    def states(self, deflections: Any, motors: Any | None = None) -> Any:
        """Return link states (2 L, columns) from deflections and rates; of derivatives, the motors' are given."""
        count = self.position.numel()
        of_motors = self.motors if motors is None else motors
        return of_motors - ca.vertcat(*[deflections[i + k, :] for i in range(count) for k in (0, count)])


def _in_turn(position: Any, velocity: Any) -> Any:
    pairs = zip(ca.vertsplit(position), ca.vertsplit(velocity), strict=True)
    return ca.vertcat(*[value for pair in pairs for value in pair])
