"""All friction that trails the speed by one pole."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, final

import casadi as ca

from stribeck.model.effect import FrictionEffect
from stribeck.model.values import Expression, Parameter, Parameters, Scale, Signals, States

SAMPLES = 2.0  # by which what sets in between two of them, seen through a filter, trails the speed in any recording


@final
class FrictionalLagWholeCurve(FrictionEffect):
    """The whole curve, viscous part and all, is read at a speed that follows by one pole.

    As simulators have it that put a filtered speed into a friction curve. What parts it from a delay is its long tail.
    """

    name = "frictional_lag"
    law = "whole_curve"
    channel = "friction"
    equation = r"G = C_0 + C_1 e^{-w/\alpha} + C_2 w, \quad B = 0, \quad T \dot w = |v| - w"
    symptom = "a residual that differs between speeding up and slowing down and dies out after every change of speed"
    shows = "velocity"
    source = "Hess & Soom (1990), the delay as one pole"
    kin = ("speed", "rest")
    elusive = True
    parameters = (Parameter("time", "s", "lag of all friction behind the speed", 0.0, 1e-4, 1.0),)
    states = ("speed",)
    state_units = MappingProxyType({"speed": "rad/s"})

    def applies(self, arm: Any, joint: int) -> bool:
        nominal = arm.joints[joint]
        return bool(nominal.friction.C1 > 0.0 or nominal.backward.C1 > 0.0)

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return ({"time": 0.02}, {"time": 0.08})

    def constants(self, constants: Parameters, s: Signals, x: States, p: Parameters) -> Parameters:
        return {**constants, "C0": constants["C0"] + constants["C2"] * x["speed"], "C2": 0.0}

    def ordinary(self, values: Mapping[str, float], scale: Scale) -> bool:
        return values["time"] < SAMPLES * scale.sample_time

    def speed(self, speed: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        return x["speed"]

    def derivatives(self, s: Signals, x: States, p: Parameters) -> dict[str, Expression]:
        return {"speed": (ca.fabs(s.velocity) - x["speed"]) / p["time"]}

    def initial(self, s: Signals, p: Parameters) -> dict[str, Expression]:
        return {"speed": ca.fabs(s.velocity)}
