"""Friction that grows with the torque that it leaves: of the motor's, what moves rotor, link and grease."""

from __future__ import annotations

from typing import final

import casadi as ca

from stribeck.model.effect import FrictionEffect, Upon
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States


@final
class LoadDependentFrictionNet(FrictionEffect):
    """A sliding level with a share of the motor's torque less that level: a drive whose rotor and link are one body.

    G = G_0 + mu |s - G| with s the motor's torque in the direction of motion, which has one solution.
    """

    name = "load_dependent_friction"
    law = "net"
    channel = "friction"
    upon = Upon.LOAD
    equation = r"G = G_0 + \mu |\tau_\mathrm{motor} - G\, \mathrm{sign}\, v|"
    symptom = "a residual against the motion, in proportion to the torque that moves rotor and link"
    shows = "load"
    source = "Hamon, Gautier & Garrec (2010); Duclusaud, Passault, Padois & Ly (2025)"
    uses_torque = True
    parameters = (Parameter("ratio", "1", "friction torque per torque that is left", 0.0, 0.0, 0.9),)

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return ({"ratio": 0.08},)

    def level(self, level: Expression, direction: float, s: Signals, x: States, p: Parameters) -> Expression:
        left = direction * s.torque - level
        return level + p["ratio"] * ca.fabs(left) / (1.0 + p["ratio"] * ca.sign(left))
