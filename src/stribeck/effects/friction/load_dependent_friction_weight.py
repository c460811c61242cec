"""Friction that grows with the weight that a joint holds."""

from __future__ import annotations

from typing import Any, final

import casadi as ca

from stribeck.model.effect import FrictionEffect, Upon
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States


@final
class LoadDependentFrictionWeight(FrictionEffect):
    """A sliding level with a share of the torque that gravity asks of the joint, whatever the motion needs besides."""

    name = "load_dependent_friction"
    law = "weight"
    channel = "friction"
    upon = Upon.LOAD
    equation = r"G = G_0 + \mu |\tau_\mathrm{gravity}|"
    symptom = "a residual against the direction of motion, in proportion to the weight that hangs on the joint"
    shows = "load"
    source = "Bittencourt, Wernholt, Sander-Tavallaey & Brogardh (2010)"
    uses_weight = True
    parameters = (Parameter("ratio", "1", "friction torque per torque of gravity", 0.0, 0.0, 0.9),)

    def applies(self, arm: Any, joint: int) -> bool:
        # of an axis that slides, the weight is the same anywhere
        return any(arm.gravity) and arm.joints[joint].kind == "revolute"

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return ({"ratio": 0.08},)

    def level(self, level: Expression, direction: float, s: Signals, x: States, p: Parameters) -> Expression:
        return level + p["ratio"] * ca.fabs(s.weight)
