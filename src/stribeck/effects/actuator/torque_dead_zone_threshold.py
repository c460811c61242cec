"""Torque that does not come at all below a least command."""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

import casadi as ca
import numpy as np

from stribeck.model.effect import ActuatorEffect, Along
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States
from stribeck.model.waves import Trace

RAMP = 0.2  # of the width, over which the torque comes back, half of it before and half beyond
QUANTILES = (0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5)  # of the size of the command, at which a width may start


@final
class TorqueDeadZoneThreshold(ActuatorEffect):
    """A bridge that makes no pulses shorter than a least one: small commands give nothing, others all they ask for."""

    name = "torque_dead_zone"
    law = "threshold"
    channel = "actuator"
    along = Along.AMPLIFIER
    equation = r"\tau = u \, \mathrm{clip}\left(\frac{|u| - 0.9\, w}{0.2\, w}, 0, 1\right)"
    symptom = "a residual that is the command itself where that is small, and nothing elsewhere"
    shows = "command"
    source = "Mohan, Undeland & Robbins (2003), blanking time and minimum pulses of switched amplifiers"
    elusive = True
    clips = True
    zone = True
    parameters = (Parameter("width", "N m", "command below which no torque comes", 0.0, 0.0),)

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return tuple({"width": part * scale.torque} for part in (0.1, 0.3))

    def starts_from(self, scale: Scale, trace: Trace) -> tuple[dict[str, float], ...]:
        size = np.abs(trace.command)
        widths = np.quantile(size, QUANTILES)
        lost = [float(np.sum(trace.residual[size < width] * trace.command[size < width])) for width in widths]
        asked = [0.5 * float(np.sum(trace.command[size < width] ** 2)) for width in widths]
        best = int(np.argmax(np.subtract(lost, asked)))
        return (*self.starts(scale), {"width": max(float(widths[best]), 1e-3 * scale.torque)})

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        return values["width"] < scale.torque

    def torque(self, torque: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        begins = (1.0 - 0.5 * RAMP) * p["width"]
        beyond = (ca.fabs(torque) - begins) / (RAMP * p["width"] + 1e-12)
        return torque * ca.fmin(ca.fmax(beyond, 0.0), 1.0)
