"""Elastic micro-motion before sliding, as a bristle."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import final

import casadi as ca

from stribeck.model.effect import FrictionEffect
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States


@final
class Presliding(FrictionEffect):
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
    parameters = (
        Parameter("stiffness", "N m/rad", "bristle stiffness", math.inf, 1e-2, 1e9, log=True),
        Parameter("damping", "N m s/rad", "bristle damping", 0.0, 0.0),
    )
    states = ("torque",)
    state_units = MappingProxyType({"torque": "N m"})
    bristle = True
    nonlinear = True

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        level = max(scale.friction, 0.01 * scale.torque)
        return tuple(
            {"stiffness": level / (part * scale.travel), "damping": 0.0} for part in (0.0006, 0.003, 0.015, 0.06)
        )

    def ordinary(self, values: Mapping[str, float], scale: Scale) -> bool:
        return 0.0 < scale.friction < values["stiffness"] * scale.gives

    def bristle_torque(self, level: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        return x["torque"] + p["damping"] * (s.velocity - s.slide * x["torque"] / _floor(level))

    def bristle_derivatives(self, level: Expression, s: Signals, x: States, p: Parameters) -> dict[str, Expression]:
        return {"torque": p["stiffness"] * (s.velocity - s.slide * x["torque"] / _floor(level))}


def _floor(level: Expression) -> Expression:
    return ca.fmax(level, 1e-9)
