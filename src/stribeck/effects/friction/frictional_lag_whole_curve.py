"""All friction that trails the speed by one pole."""

from __future__ import annotations

from types import MappingProxyType
from typing import final

from stribeck.model.trailing import TrailingFriction
from stribeck.model.values import Parameter, Parameters, Signals, States


@final
class FrictionalLagWholeCurve(TrailingFriction):
    """The whole curve, viscous part and all, is read at a speed that follows by one pole.

    As simulators have it that put a filtered speed into a friction curve. What parts it from a delay is its long tail.
    """

    law = "whole_curve"
    whole = True
    equation = r"G = C_0 + C_1 e^{-w/\alpha} + C_2 w, \quad B = 0, \quad T \dot w = |v| - w"
    symptom = "a residual that differs between speeding up and slowing down and dies out after every change of speed"
    source = "Hess & Soom (1990), the delay as one pole"
    parameters = (Parameter("time", "s", "lag of all friction behind the speed", 0.0, 1e-4, 1.0),)
    states = ("speed",)
    state_units = MappingProxyType({"speed": "rad/s"})

    def constants(self, constants: Parameters, s: Signals, x: States, p: Parameters) -> Parameters:
        return self.with_viscous(constants, x)
