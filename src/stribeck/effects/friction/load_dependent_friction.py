"""Friction that grows with the torque that the joint transmits."""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

import casadi as ca

from stribeck.model.effect import FrictionEffect, Upon
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States


@final
class LoadDependentFriction(FrictionEffect):
    """A sliding level with a share of the magnitude of the torque that the link takes."""

    name = "load_dependent_friction"
    law = "proportional"
    channel = "friction"
    upon = Upon.LOAD
    equation = r"G = G_0 + \mu |\tau_\mathrm{load}|"
    symptom = "a residual against the direction of motion, in proportion to the transmitted torque"
    shows = "load"
    source = "Hamon, Gautier & Garrec (2010); Duclusaud, Passault, Padois & Ly (2025)"
    parameters = (Parameter("ratio", "1", "friction torque per transmitted torque", 0.0, 0.0, 0.9),)
    uses_load = True

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return ({"ratio": 0.08},)

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        return scale.driven  # what the link of another joint takes is no load, but that joint's friction

    def level(self, level: Expression, direction: float, s: Signals, x: States, p: Parameters) -> Expression:
        return level + p["ratio"] * ca.fabs(s.load)
