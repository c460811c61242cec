"""A stand that slides under the arm: what its motion adds to the links' inertia and torques.

Its acceleration follows from those of the links. Put into their equations, M a + c b + h = tau with
(m + M_arm) b + c' a + f = F, it leaves equations in the links' accelerations alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca

from stribeck.model.values import Expression


@dataclass(frozen=True)
class Stand:
    """A stand at one instant.

    Attributes
    ----------
    drive : expression
        Acceleration that it would have if the links had none, m/s^2.
    coupling : (n, 1)
        Torque at each joint by its acceleration, N m/(m/s^2).
    mass : expression
        Of all that slides, kg.
    """

    drive: Expression
    coupling: Any
    mass: Expression

    def acceleration(self, links: Sequence[Expression]) -> Expression:
        """Return its acceleration, m/s^2, with those of the links (n), rad/s^2."""
        return self.drive - ca.dot(self.coupling, ca.vertcat(*links)) / self.mass

    def loads(self, loads: Sequence[Expression], links: Sequence[Expression]) -> list[Expression]:
        """Return the links' torques (n), N m, that were computed on firm ground at these accelerations (n)."""
        along = self.acceleration(links)
        return [load + self.coupling[j] * along for j, load in enumerate(loads)]

    def inertia(self, mass: Any) -> Any:
        """Return the links' mass matrix (n, n), kg m^2, as it is where the ground gives way."""
        return mass - ca.mtimes(self.coupling, self.coupling.T) / self.mass
