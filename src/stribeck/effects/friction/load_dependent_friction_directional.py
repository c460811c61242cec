"""Friction of a gear that its own motor has to overcome, too: more where the motor drives than where it is driven."""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

import casadi as ca

from stribeck.model.effect import FrictionEffect, Upon
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States


@final
class LoadDependentFrictionDirectional(FrictionEffect):
    """A share of the torque that enters the transmission, its friction included; the other law takes what leaves.

    With the load s and the viscous part B in the direction of motion, G = G_0 + mu |s + G + B|, which has one solution
    for mu < 1.
    """

    name = "load_dependent_friction"
    law = "directional"
    channel = "friction"
    upon = Upon.LOAD
    equation = r"G = G_0 + \mu |\tau_\mathrm{load} + B + G\, \mathrm{sign}\, v|"
    symptom = "a residual against the motion in proportion to the transmitted torque, more where the motor drives"
    shows = "load"
    source = "Hamon, Gautier & Garrec (2010); Duclusaud, Passault, Padois & Ly (2025)"
    parameters = (Parameter("ratio", "1", "friction torque per torque that enters", 0.0, 0.0, 0.9),)
    uses_load = True

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return ({"ratio": 0.08},)

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        return scale.driven  # what the link of another joint takes is no load, but that joint's friction

    def level(self, level: Expression, direction: float, s: Signals, x: States, p: Parameters) -> Expression:
        entering = direction * (s.load + s.viscous) + level
        return level + p["ratio"] * ca.fabs(entering) / (1.0 - p["ratio"] * ca.sign(entering))
