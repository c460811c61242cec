"""Torque that a drive gives ever less of, the more is asked."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import final

import casadi as ca

from stribeck.model.effect import ActuatorEffect, Along
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States

STRAIGHT = 0.02  # of a torque twice the typical one, by which iron takes from any motor's


@final
class TorqueSaturationSmooth(ActuatorEffect):
    """A limit that is come to gradually, as iron saturates and as amplifiers round off."""

    name = "torque_saturation"
    law = "smooth"
    channel = "actuator"
    along = Along.LIMIT
    equation = r"\tau = L \tanh(u / L)"
    symptom = "a residual towards zero torque, that grows with the cube of the command"
    shows = "command"
    source = "Hughes & Drury (2019), ch. 1 (saturation of iron)"
    clips = True
    parameters = (Parameter("limit", "N m", "largest torque", math.inf, 1e-6, 1e9, log=True),)

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return tuple({"limit": times * scale.torque} for times in (1.5, 3.0))

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        return scale.may_limit(values["limit"])

    def ordinary(self, values: Mapping[str, float], scale: Scale) -> bool:
        much = 2.0 * scale.torque / values["limit"]
        return math.tanh(much) >= (1.0 - STRAIGHT) * much

    def torque(self, torque: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        return p["limit"] * ca.tanh(torque / p["limit"])
