"""Constant torque on top of the command."""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

from stribeck.model.effect import ActuatorEffect, Along
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States


@final
class TorqueOffset(ActuatorEffect):
    """The bias of an amplifier or of a torque sensor in the drive."""

    name = "torque_offset"
    channel = "actuator"
    along = Along.SHAFT
    equation = r"\tau = u + \tau_0"
    symptom = "a constant residual, whatever the pose, the direction and the speed"
    shows = "position"
    source = "Gautier & Briot (2014), offset of amplifier and friction together"
    parameters = (Parameter("offset", "N m", "torque without a command"),)

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return ({"offset": 0.1 * scale.torque},)

    def ordinary(self, values: Mapping[str, float], scale: Scale) -> bool:
        return abs(values["offset"]) < scale.stray

    def torque(self, torque: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        return torque + p["offset"]
