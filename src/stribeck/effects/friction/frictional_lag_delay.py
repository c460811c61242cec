"""Friction of the speed of a moment ago."""

from __future__ import annotations

from typing import final

from stribeck.model.trailing import DELAY, DELAY_UNITS, TrailingFriction
from stribeck.model.values import Parameter, Parameters, Signals, States


@final
class FrictionalLagDelay(TrailingFriction):
    """All friction, its viscous part too, follows the speed by a delay: the source's own law."""

    law = "delay"
    whole = True
    equation = r"G = C_0 + C_1 e^{-w/\alpha} + C_2 w, \quad B = 0, \quad w(t) \approx |v(t - T)|"
    symptom = "a residual that differs between speeding up and slowing down, at low and at high speed"
    source = "Hess & Soom (1990)"
    parameters = (Parameter("time", "s", "delay of friction behind the speed", 0.0, 1e-4, 1.0),)
    states = DELAY
    state_units = DELAY_UNITS

    def constants(self, constants: Parameters, s: Signals, x: States, p: Parameters) -> Parameters:
        return self.with_viscous(constants, x)
