"""A drive whose gain grows with its torque: an effect that the library does not hold, in a package of its own.

Hooks take and return CasADi expressions; what a class leaves out passes its stage unchanged. From this one declaration
the effect is a candidate of `stribeck diagnose`, an entry of arm files, and part of simulation and export.
"""

from __future__ import annotations

import math
from typing import final

from stribeck.effects import ActuatorEffect, Expression, Parameter, Parameters, Scale, Signals, States


@final
class DriveHardening(ActuatorEffect):
    """Torque beyond what is commanded, by the cube of the command: an elastic torque sensor calibrated at low loads."""

    name = "drive_hardening"
    channel = "actuator"
    equation = r"\tau = u (1 + (u/U)^2)"
    symptom = "a residual in proportion to the cube of the command: nothing at small torques, much at large ones"
    shows = "command"
    source = "an example of one's own law; name here who measured it"
    parameters = (Parameter("doubling", "N m", "torque at which the gain has doubled", math.inf, 1e-3, 1e9, log=True),)

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        """Return one trial: a ninth more torque than commanded at the rms torque."""
        return ({"doubling": 3.0 * max(scale.torque, 1e-3)},)

    def torque(self, torque: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        """Return the torque after the drive, N m."""
        return torque * (1.0 + (torque / p["doubling"]) ** 2)
