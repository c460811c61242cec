"""Friction whose falling part belongs to the speed of a moment ago."""

from __future__ import annotations

from types import MappingProxyType
from typing import final

from stribeck.model.trailing import TrailingFriction
from stribeck.model.values import Parameter

NAMES = ("first", "second", "third")  # of the poles


@final
class FrictionalLagFallingPart(TrailingFriction):
    """The part that falls with the speed follows by a delay, the viscous part at once: the seven-parameter model's law.

    The delay is a chain of three poles of the same mean delay, so that simulation, linearisation and export have
    states and no memory.
    """

    law = "falling_part"
    equation = r"G = C_0 + C_1 e^{-w/\alpha}, \quad w(t) \approx |v(t - T)|"
    symptom = "a residual at low speed that differs between speeding up and slowing down, and comes late"
    source = "Armstrong-Helouvry, Dupont & Canudas de Wit (1994), the seven-parameter model"
    parameters = (Parameter("time", "s", "delay of the falling part behind the speed", 0.0, 1e-4, 1.0),)
    states = NAMES
    state_units = MappingProxyType(dict.fromkeys(NAMES, "rad/s"))
