"""Drag that grows with the square of the velocity."""

from __future__ import annotations

from typing import final

import casadi as ca

from stribeck.model.effect import FrictionEffect
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States


@final
class QuadraticDamping(FrictionEffect):
    """Turbulent drag: churned lubricant, air, water."""

    name = "quadratic_damping"
    channel = "friction"
    equation = r"B = C_2 v + c\,v |v|"
    symptom = "a residual against the motion that grows faster than the velocity, nothing at low speed"
    shows = "velocity"
    source = "Fossen (1994), drag in fluids"
    kin = ("speed",)
    parameters = (Parameter("coefficient", "N m s^2/rad^2", "torque per squared velocity", 0.0, 0.0),)

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return ({"coefficient": 0.1 * scale.torque / scale.speed**2},)

    def viscous(self, torque: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        return torque + p["coefficient"] * s.velocity * ca.fabs(s.velocity)
