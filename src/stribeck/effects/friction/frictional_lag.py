"""Friction that follows a change of velocity late."""

from __future__ import annotations

from typing import Any, final

import casadi as ca

from stribeck.model.effect import Expression, FrictionEffect, Parameter, Parameters, Scale, Signals, States


@final
class FrictionalLag(FrictionEffect):
    """The level belongs to the speed of a moment ago, as a lubricant film takes time to build and to collapse.

    The pure delay of the source as two equal poles, whose mean delay is the same.
    """

    name = "frictional_lag"
    channel = "friction"
    equation = (
        r"G = C_0 + C_1 e^{-w/\alpha}, \quad \tfrac{T}{2} \dot w = w_1 - w, \quad \tfrac{T}{2} \dot w_1 = |v| - w_1"
    )
    symptom = "a residual at low speed that differs between speeding up and slowing down: a loop over velocity"
    source = "Hess & Soom (1990); Armstrong-Helouvry, Dupont & Canudas de Wit (1994)"
    parameters = (Parameter("time", "s", "lag of the friction level behind the speed", 0.0, 1e-4, 1.0),)
    states = ("first", "speed")

    def applies(self, arm: Any, joint: int) -> bool:
        nominal = arm.joints[joint]
        return bool(nominal.friction.C1 > 0.0 or nominal.backward.C1 > 0.0)

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return ({"time": 0.02}, {"time": 0.08})

    def speed(self, speed: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        return x["speed"]

    def derivatives(self, s: Signals, x: States, p: Parameters) -> dict[str, Expression]:
        rate = 2.0 / p["time"]
        return {"first": rate * (ca.fabs(s.velocity) - x["first"]), "speed": rate * (x["first"] - x["speed"])}

    def initial(self, s: Signals, p: Parameters) -> dict[str, Expression]:
        speed = ca.fabs(s.velocity)
        return {"first": speed, "speed": speed}
