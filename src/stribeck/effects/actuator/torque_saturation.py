"""Torque that the drive cannot give."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import final

import casadi as ca

from stribeck.model.effect import ActuatorEffect, Along
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States


@final
class TorqueSaturation(ActuatorEffect):
    """A symmetric limit of the torque (current or voltage) below the one that the command is held to."""

    name = "torque_saturation"
    law = "constant"
    channel = "actuator"
    along = Along.LIMIT
    equation = r"\tau = \max(-L, \min(L, u))"
    symptom = "a residual only at the largest commands, towards zero torque, that grows with the command beyond a level"
    shows = "command"
    source = "Slotine & Li (1991), ch. 5"
    clips = True
    parameters = (Parameter("limit", "N m", "largest torque", math.inf, 1e-6, 1e9, log=True),)

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        # below the peak of the command, or nothing would say which way to go
        return tuple({"limit": times * scale.torque} for times in (1.2, 1.8, 2.6))

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        return scale.may_limit(values["limit"])

    def torque(self, torque: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        return ca.fmax(ca.fmin(torque, p["limit"]), -p["limit"])
