"""Torque that gets lost around zero command."""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

import casadi as ca

from stribeck.model.effect import ActuatorEffect, Along
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States


@final
class TorqueDeadZone(ActuatorEffect):
    """A symmetric dead zone: cross-over of an amplifier, overlap of a valve."""

    name = "torque_dead_zone"
    law = "shifted"
    channel = "actuator"
    along = Along.AMPLIFIER
    equation = r"\tau = \mathrm{sign}(u) \max(|u| - w, 0)"
    symptom = "a residual of constant size whose sign is that of the command, not that of the motion"
    shows = "command"
    source = "Tao & Kokotovic (1996)"
    elusive = True
    clips = True
    zone = True
    parameters = (Parameter("width", "N m", "torque lost, half the width of the zone", 0.0, 0.0),)

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return ({"width": 0.1 * scale.torque},)

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        return values["width"] < scale.torque

    def torque(self, torque: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        return torque - ca.fmax(ca.fmin(torque, p["width"]), -p["width"])
