"""Friction that follows a change of velocity late."""

from __future__ import annotations

from types import MappingProxyType
from typing import final

from stribeck.model.trailing import TrailingFriction
from stribeck.model.values import Parameter


@final
class FrictionalLag(TrailingFriction):
    """The level belongs to the speed of a moment ago, as a lubricant film takes time to build and to collapse.

    The pure delay of the source as one pole, whose mean delay is the same.
    """

    law = "one_pole"
    equation = r"G = C_0 + C_1 e^{-w/\alpha}, \quad T \dot w = |v| - w"
    symptom = "a residual at low speed that differs between speeding up and slowing down: a loop over velocity"
    source = "Hess & Soom (1990); Armstrong-Helouvry, Dupont & Canudas de Wit (1994)"
    parameters = (Parameter("time", "s", "lag of the friction level behind the speed", 0.0, 1e-4, 1.0),)
    states = ("speed",)
    state_units = MappingProxyType({"speed": "rad/s"})
