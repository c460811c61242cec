"""Friction that follows a change of velocity late."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, final

import casadi as ca

from stribeck.model.effect import FrictionEffect
from stribeck.model.values import Expression, Parameter, Parameters, Scale, Signals, States

SAMPLES = 2.0  # by which what sets in between two of them, seen through a filter, trails the speed in any recording


@final
class FrictionalLag(FrictionEffect):
    """The level belongs to the speed of a moment ago, as a lubricant film takes time to build and to collapse.

    The pure delay of the source as one pole, whose mean delay is the same.
    """

    name = "frictional_lag"
    law = "one_pole"
    channel = "friction"
    equation = r"G = C_0 + C_1 e^{-w/\alpha}, \quad T \dot w = |v| - w"
    symptom = "a residual at low speed that differs between speeding up and slowing down: a loop over velocity"
    shows = "velocity"
    source = "Hess & Soom (1990); Armstrong-Helouvry, Dupont & Canudas de Wit (1994)"
    kin = ("speed", "rest")
    elusive = True
    parameters = (Parameter("time", "s", "lag of the friction level behind the speed", 0.0, 1e-4, 1.0),)
    states = ("speed",)
    state_units = MappingProxyType({"speed": "rad/s"})

    def applies(self, arm: Any, joint: int) -> bool:
        nominal = arm.joints[joint]
        return bool(nominal.friction.C1 > 0.0 or nominal.backward.C1 > 0.0)

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return ({"time": 0.02}, {"time": 0.08})

    def ordinary(self, values: Mapping[str, float], scale: Scale) -> bool:
        return values["time"] < SAMPLES * scale.sample_time

    def speed(self, speed: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        return x["speed"]

    def derivatives(self, s: Signals, x: States, p: Parameters) -> dict[str, Expression]:
        return {"speed": (ca.fabs(s.velocity) - x["speed"]) / p["time"]}

    def initial(self, s: Signals, p: Parameters) -> dict[str, Expression]:
        return {"speed": ca.fabs(s.velocity)}
