"""Friction that grows with the torque of the motor, which its current tells."""

from __future__ import annotations

from typing import final

import casadi as ca

from stribeck.model.effect import FrictionEffect, Upon
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States


@final
class LoadDependentFrictionMotor(FrictionEffect):
    """A sliding level with a share of all the torque that the motor gives, its rotor's acceleration included."""

    name = "load_dependent_friction"
    law = "motor"
    channel = "friction"
    upon = Upon.LOAD
    equation = r"G = G_0 + \mu |\tau_\mathrm{motor}|"
    symptom = "a residual against the motion, in proportion to the motor's torque"
    shows = "load"
    source = "Hamon, Gautier & Garrec (2010); Duclusaud, Passault, Padois & Ly (2025)"
    uses_torque = True
    parameters = (Parameter("ratio", "1", "friction torque per motor torque", 0.0, 0.0, 0.9),)

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return ({"ratio": 0.08},)

    def level(self, level: Expression, direction: float, s: Signals, x: States, p: Parameters) -> Expression:
        return level + p["ratio"] * ca.fabs(s.torque)
