"""Friction whose falling part belongs to the speed of a moment ago."""

from __future__ import annotations

from typing import final

from stribeck.model.trailing import DELAY, DELAY_UNITS, TrailingFriction
from stribeck.model.values import Parameter


@final
class FrictionalLagFallingPart(TrailingFriction):
    """The falling part follows the speed by a delay, the viscous part at once, as in the seven-parameter model."""

    law = "falling_part"
    equation = r"G = C_0 + C_1 e^{-w/\alpha}, \quad w(t) \approx |v(t - T)|"
    symptom = "a residual at low speed that differs between speeding up and slowing down, and comes late"
    source = "Armstrong-Helouvry, Dupont & Canudas de Wit (1994), the seven-parameter model"
    parameters = (Parameter("time", "s", "delay of the falling part behind the speed", 0.0, 1e-4, 1.0),)
    states = DELAY
    state_units = DELAY_UNITS
