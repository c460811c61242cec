"""Dissimilar friction in the two directions of motion."""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

import casadi as ca

from stribeck.model.effect import FrictionEffect
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States

UNLIKE = 0.05  # of a joint's friction, by which any two directions differ


@final
class AsymmetricFriction(FrictionEffect):
    """Half the difference between forward and backward friction, on the Coulomb and the viscous term."""

    name = "asymmetric_friction"
    channel = "friction"
    equation = r"G_\pm = G \pm \Delta_0, \quad B = C_2 v + \Delta_2 |v|"
    symptom = "a residual whose sign does not turn with the direction of motion, only while the joint moves"
    shows = "velocity"
    source = "paper, sections 2.1 and 2.2; Armstrong-Helouvry (1991)"
    parameters = (
        Parameter("coulomb", "N m", "half the difference of the Coulomb levels, forward less backward"),
        Parameter("viscous", "N m s/rad", "half the difference of the viscous constants, forward less backward"),
    )

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        size = 0.1 * max(scale.friction, 0.02 * scale.torque)
        return ({"coulomb": size, "viscous": 0.0}, {"coulomb": 0.0, "viscous": size / scale.speed})

    def ordinary(self, values: Mapping[str, float], scale: Scale) -> bool:
        unlike = abs(values["coulomb"]) + abs(values["viscous"]) * scale.speed
        return unlike < max(scale.stray, UNLIKE * scale.friction)

    def level(self, level: Expression, direction: float, s: Signals, x: States, p: Parameters) -> Expression:
        return ca.fmax(level + direction * p["coulomb"], 0.0)

    def viscous(self, torque: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        return torque + p["viscous"] * ca.fabs(s.velocity)
