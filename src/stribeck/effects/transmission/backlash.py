"""Play between motor and link."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import final

import casadi as ca
import numpy as np

from stribeck.model.effect import TransmissionEffect
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters

GAPS = (4e-4, 0.08, 8)  # of the travel: half or twice the right one is near enough, for most
LEAST_GAP = 0.5  # of what the typical torque winds up: a play that is less is a spring
ROUGH = 0.15  # of each value: less is as rough as a point, and so much is as near as a fit has to start
ONSET = 0.3  # of the gap: the penetration over which the damper comes in; less is too sudden for a simulation


@final
class Backlash(TransmissionEffect):
    """A spring with a dead zone between motor and link; the encoder is on the motor.

    The faces never pull. The damper comes in with the penetration x: of ``damping`` the share x / (x + 0.3 gap) acts,
    where x is about torque / stiffness. A value measured at one torque is to be divided by the share there.
    """

    name = "backlash"
    channel = "transmission"
    equation = (
        r"\tau = k x + d\,(\dot\theta - \dot q)\,\frac{|x|}{|x| + 0.3\,\Delta}\ [0\ \text{where that pulls}],"
        r" \quad x = \mathrm{dz}_{\Delta/2}(\theta - q)"
    )
    symptom = "a pulse in the residual wherever the transmitted torque changes sign"
    shows = "load reversal"
    source = "Nordin & Gutman (2002)"
    nonlinear = True
    zone = True
    rough = ROUGH
    damper = "damping"
    room = "gap"
    parameters = (
        Parameter("gap", "rad", "full width of the play", 0.0, 1e-7, 0.5, log=True),
        Parameter("stiffness", "N m/rad", "contact stiffness", math.inf, 1e-8, 1e11, log=True),
        Parameter("damping", "N m s/rad", "contact damping, pressed in far beyond 0.3 gap", 0.0, 1e-9, 1e8, log=True),
    )

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        # the contact of a play is as stiff as its motor and link are unlike: some 30 Hz
        rate = 6.2832 * 30.0
        stiffness, damping = scale.link * rate**2, scale.link * rate
        gaps = [part * scale.travel for part in np.geomspace(*GAPS)]
        trials = tuple({"gap": gap, "stiffness": stiffness, "damping": damping} for gap in gaps)
        return tuple(trial for trial in trials if self.plausible(trial, scale)) or trials[-1:]

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        wide = values["gap"] > scale.gives  # any contact gives by so much
        return wide and values["gap"] * values["stiffness"] > LEAST_GAP * scale.torque

    def transmitted(self, deflection: Expression, rate: Expression, p: Parameters) -> Expression:
        half = 0.5 * p["gap"]
        over = ca.fmax(deflection - half, 0.0) + ca.fmin(deflection + half, 0.0)
        pressed = ca.fabs(over) / (ca.fabs(over) + ONSET * p["gap"] + 1e-9)
        push = p["stiffness"] * over + p["damping"] * rate * pressed
        return ca.if_else(over > 0.0, ca.fmax(push, 0.0), ca.fmin(push, 0.0))

    def touching(self, deflection: Expression, rate: Expression, p: Parameters) -> tuple[Expression, Expression]:
        return p["stiffness"], p["damping"]

    def deflection(self, torque: Expression, p: Parameters) -> Expression:
        return torque / p["stiffness"] + 0.5 * p["gap"] * ca.sign(torque)
