"""Elastic micro-motion before sliding, as a bristle."""

from __future__ import annotations

from types import MappingProxyType
from typing import final

from stribeck.model.bristles import Bristle, at_least
from stribeck.model.values import Expression, Parameters, Signals, States


@final
class Presliding(Bristle):
    """A bristle of stiffness sigma_0 and damping sigma_1 in place of the sign function.

    The state is the bristle's torque b = sigma_0 z, which stays of the size of the friction level.
    """

    name = "presliding"
    law = "lugre"
    channel = "friction"
    equation = r"\dot b = \sigma_0 (v - |v| b / G(v)), \quad \tau_f = b + \sigma_1 \dot b / \sigma_0 + C_2 v"
    symptom = "a residual at velocity reversals that grows with the distance moved since, not with time"
    shows = "travel"
    source = "Dahl (1968); LuGre: Canudas de Wit, Olsson, Astrom & Lischinsky (1995)"
    kin = ("rest",)
    states = ("torque",)
    state_units = MappingProxyType({"torque": "N m"})

    def bristle_torque(self, level: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        return x["torque"] + p["damping"] * (s.velocity - s.slide * x["torque"] / at_least(level))

    def bristle_derivatives(self, level: Expression, s: Signals, x: States, p: Parameters) -> dict[str, Expression]:
        return {"torque": p["stiffness"] * (s.velocity - s.slide * x["torque"] / at_least(level))}
