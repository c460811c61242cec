"""Torque that the supply's voltage leaves a turning motor."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import final

import casadi as ca

from stribeck.model.effect import ActuatorEffect, Along
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States


@final
class TorqueSaturationBackEmf(ActuatorEffect):
    """A limit that falls with speed where the motor drives, as its back-EMF takes voltage; the other law's is constant.

    Where the motor brakes, the limit of the current stays what it is at rest.
    """

    name = "torque_saturation"
    law = "back_emf"
    channel = "actuator"
    along = Along.LIMIT
    equation = r"|\tau| \leq L (1 - w \max(0, v\, \mathrm{sign}\, u))"
    symptom = "a residual only where a large command drives a fast joint"
    shows = "command"
    source = "Slotine & Li (1991), ch. 5; Hughes & Drury (2019), ch. 3 (torque against speed)"
    clips = True
    parameters = (
        Parameter("limit", "N m", "largest torque at rest", math.inf, 1e-6, 1e9, log=True),
        Parameter("fade", "s/rad", "part of the limit lost per speed, 1 / no-load speed", 0.0, 0.0, 1e3),
    )

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return tuple({"limit": times * scale.torque, "fade": 0.2 / scale.speed} for times in (1.5, 2.5, 4.0))

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        return scale.may_limit(values["limit"])

    def torque(self, torque: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        ahead, back = (p["limit"] * ca.fmax(1.0 - p["fade"] * ca.fmax(v, 0.0), 0.0) for v in (s.velocity, -s.velocity))
        return ca.fmax(ca.fmin(torque, ahead), -back)
