"""Friction of the speed of a moment ago."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, final

import casadi as ca

from stribeck.model.effect import FrictionEffect
from stribeck.model.values import Expression, Parameter, Parameters, Scale, Signals, States

SAMPLES = 2.0  # by which what sets in between two of them, seen through a filter, trails the speed in any recording
NAMES = ("first", "second", "third")  # of the poles


@final
class FrictionalLagDelay(FrictionEffect):
    """All friction, its viscous part too, follows the speed by a delay: the source's own law.

    The delay is a chain of three poles of the same mean delay, so that simulation, linearisation and export have
    states and no memory.
    """

    name = "frictional_lag"
    law = "delay"
    channel = "friction"
    equation = r"G = C_0 + C_1 e^{-w/\alpha} + C_2 w, \quad B = 0, \quad w(t) \approx |v(t - T)|"
    symptom = "a residual that differs between speeding up and slowing down, at low and at high speed"
    shows = "velocity"
    source = "Hess & Soom (1990)"
    kin = ("speed", "rest")
    elusive = True
    parameters = (Parameter("time", "s", "delay of friction behind the speed", 0.0, 1e-4, 1.0),)
    states = NAMES
    state_units = MappingProxyType(dict.fromkeys(NAMES, "rad/s"))

    def applies(self, arm: Any, joint: int) -> bool:
        nominal = arm.joints[joint]
        return bool(nominal.friction.C1 > 0.0 or nominal.backward.C1 > 0.0)

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return ({"time": 0.02}, {"time": 0.08})

    def constants(self, constants: Parameters, s: Signals, x: States, p: Parameters) -> Parameters:
        return {**constants, "C0": constants["C0"] + constants["C2"] * x[NAMES[-1]], "C2": 0.0}

    def ordinary(self, values: Mapping[str, float], scale: Scale) -> bool:
        return values["time"] < SAMPLES * scale.sample_time

    def speed(self, speed: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        return x[NAMES[-1]]

    def derivatives(self, s: Signals, x: States, p: Parameters) -> dict[str, Expression]:
        before = (ca.fabs(s.velocity), *(x[name] for name in NAMES))
        rate = len(NAMES) / p["time"]
        return {name: rate * (before[i] - x[name]) for i, name in enumerate(NAMES)}

    def initial(self, s: Signals, p: Parameters) -> dict[str, Expression]:
        return dict.fromkeys(NAMES, ca.fabs(s.velocity))
