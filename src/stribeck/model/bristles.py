"""What laws of a bristle share: a contact that moves elastically before it slides."""

from __future__ import annotations

import math
from collections.abc import Mapping

import casadi as ca

from stribeck.model.effect import FrictionEffect
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, States

PARTS = (0.0006, 0.003, 0.015, 0.06)  # of the travel, that a bristle may give before it slides


class Bristle(FrictionEffect):
    """A stiffness, and a damping beside it, in place of the sign function.

    The states are torques, N m, that together are the contact's: each element's deflection times its stiffness.
    """

    bristle = True
    nonlinear = True
    parameters = (
        Parameter("stiffness", "N m/rad", "stiffness of the contact before it slides", math.inf, 1e-8, 1e12, log=True),
        Parameter("damping", "N m s/rad", "damping of the contact before it slides", 0.0, 0.0),
    )

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        """Return trials of what a bristle may give, from some encoder steps to a good part of the travel."""
        level = max(scale.friction, 0.01 * scale.torque)
        return tuple({"stiffness": level / (part * scale.travel), "damping": 0.0} for part in PARTS)

    def bristle_mean_torque(self, rate: Expression, x: States, p: Parameters) -> Expression:
        """Return what the elements hold, and what damps them at the mean rate at which they bend."""
        return sum(x[name] for name in self.states) + p["damping"] * rate / p["stiffness"]

    def ordinary(self, values: Mapping[str, float], scale: Scale) -> bool:
        """Return whether it gives no more before it slides than any contact does."""
        return 0.0 < scale.friction < values["stiffness"] * scale.gives


def at_least(level: Expression) -> Expression:
    """Return a friction level that can be divided by."""
    return ca.fmax(level, 1e-9)
