"""Elastic drive between motor and link."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import final

from stribeck.model.effect import TransmissionEffect
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters
from stribeck.model.waves import Trace, ringing

DAMPED = 0.5  # of critical: a shaft rings


@final
class JointFlexibility(TransmissionEffect):
    """A linear torsion spring and damper between motor and link; the encoder is on the motor."""

    name = "joint_flexibility"
    channel = "transmission"
    equation = r"\tau = k (\theta - q) + d (\dot\theta - \dot q)"
    symptom = "a lightly damped resonance in the residual, and inertia that seems to grow with frequency"
    shows = "frequency"
    source = "Spong (1987)"
    filters = True
    nonlinear = True
    parameters = (
        Parameter("stiffness", "N m/rad", "torsional stiffness", math.inf, 1e-8, 1e11, log=True),
        Parameter("damping", "N m s/rad", "torsional damping", 0.0, 1e-9, 1e8, log=True),
    )

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        # a shaft that is stiff beside what is left of it is found from stiffer ones alone
        return tuple(_start(scale, hertz) for hertz in (4.0, 8.0, 16.0, 32.0, 64.0))

    def starts_from(self, scale: Scale, trace: Trace) -> tuple[dict[str, float], ...]:
        return (*self.starts(scale), *(_start(scale, hertz) for hertz in ringing(trace, (0.8, 40.0))))

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        # more is a link that hardly follows its motor at all, and so not the noise of its encoder either
        return values["damping"] < DAMPED * 2.0 * math.sqrt(values["stiffness"] * scale.link)

    def transmitted(self, deflection: Expression, rate: Expression, p: Parameters) -> Expression:
        return p["stiffness"] * deflection + p["damping"] * rate

    def deflection(self, torque: Expression, p: Parameters) -> Expression:
        return torque / p["stiffness"]


def _start(scale: Scale, hertz: float) -> dict[str, float]:
    """Return the values of a shaft on which the link rings so fast."""
    omega = 6.2832 * hertz
    return {"stiffness": scale.link * omega**2, "damping": 0.2 * scale.link * omega}
