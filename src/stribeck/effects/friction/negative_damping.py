"""Friction that falls with velocity, where the nominal model has none of it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, final

import casadi as ca

from stribeck.model.effect import FrictionEffect
from stribeck.model.scale import Scale
from stribeck.model.tustin import NARROWEST, falls
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States


@final
class NegativeDamping(FrictionEffect):
    """The falling part of Tustin's law, added to a nominal model of Coulomb and viscous friction.

    Where the nominal model has a falling part already, its own constants are re-tuned instead.
    """

    name = "negative_damping"
    law = "exponential"
    channel = "friction"
    equation = r"G = C_0 + A \exp(-|v| / v_s)"
    symptom = "a residual against the motion at low speed only, and stick-slip or hunting that the model lacks"
    shows = "velocity"
    source = "Tustin (1947); paper, eq. (1)"
    kin = ("speed",)
    parameters = (
        Parameter("amount", "N m", "break-away above Coulomb friction", 0.0, 0.0),
        Parameter("velocity", "rad/s", "velocity over which it falls", 0.1, 1e-6, 1e3, log=True),
    )

    def applies(self, arm: Any, joint: int) -> bool:
        nominal = arm.joints[joint]
        return not (falls(nominal.friction) or falls(nominal.backward))

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        size = 0.3 * max(scale.friction, 0.02 * scale.torque)
        return tuple({"amount": size, "velocity": part * scale.speed} for part in (0.1, 0.4))

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        # a peak of any height fits a joint at rest where it is narrow enough
        low = values["amount"] < 2.0 * max(scale.friction, scale.torque)
        return low and values["velocity"] > NARROWEST * scale.speed

    def level(self, level: Expression, direction: float, s: Signals, x: States, p: Parameters) -> Expression:
        return level + p["amount"] * ca.exp(-ca.fabs(s.velocity) / p["velocity"])
