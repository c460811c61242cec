"""Tustin's friction model, equation (1) of Popovic, Goldenberg, Shimoga and Hui."""

from __future__ import annotations

import casadi as ca

from stribeck.arm import Friction
from stribeck.model.values import Expression, Parameters

NONE = 1e-6  # of the Coulomb friction: a falling part of less is what a fit has left at its bound
NARROWEST = 1e-3  # of the typical speed, over which a part falls: slower is rest, on an axis in m as well


def tustin_level(speed: Expression, constants: Parameters) -> Expression:
    """Return the sliding level C0 + C1 exp(-|v|/alpha) in N m, the viscous term apart.

    Parameters
    ----------
    speed : expression
        Absolute velocity, rad/s, at least 0.
    constants : mapping
        ``C0``, ``C1`` (N m) and ``alpha`` (rad/s). At speed 0 this is the break-away torque C0 + C1 (eq. 9).
    """
    return constants["C0"] + constants["C1"] * ca.exp(-speed / constants["alpha"])


def tustin_viscous(velocity: Expression, forward: Expression, backward: Expression) -> Expression:
    """Return the viscous torque C2 v (N m), with its own C2 (N m s/rad) for each direction."""
    return forward * ca.fmax(velocity, 0.0) + backward * ca.fmin(velocity, 0.0)


def falls(friction: Friction) -> bool:
    """Return whether friction has a part that falls with the speed."""
    return friction.C1 > NONE * friction.C0
