"""Torque of the motor that is periodic in its position."""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

import casadi as ca
import numpy as np

from stribeck.model.effect import ActuatorEffect, Along
from stribeck.model.overtones import size_of
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States
from stribeck.model.waves import Trace, strongest_waves


@final
class Cogging(ActuatorEffect):
    """One harmonic of the pull of the magnets on the slots, there without any current."""

    name = "cogging"
    law = "one_wave"
    channel = "actuator"
    along = Along.IRON
    equation = r"\tau = u + a \sin N q + b \cos N q"
    symptom = "a residual that repeats with position, of the same sign in both directions and at rest"
    shows = "position"
    source = "Jahns & Soong (1996); Hanselman (2006)"
    kin = ("wave", "curve")
    parameters = (
        Parameter("sine", "N m", "amplitude of the sine"),
        Parameter("cosine", "N m", "amplitude of the cosine"),
        Parameter("harmonic", "1/rad", "cycles per turn", 1.0, 1.0, 1e6),
    )

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        size = 0.05 * scale.torque
        seen = 7.0 / scale.travel  # a period of them
        return tuple({"sine": size, "cosine": size, "harmonic": max(n, seen)} for n in (4.0, 6.0, 8.0, 12.0, 24.0))

    def starts_from(self, scale: Scale, trace: Trace) -> tuple[dict[str, float], ...]:
        waves = strongest_waves(trace.position, np.ones_like(trace.position), trace, scale.rates())
        return tuple({"sine": -w.sine, "cosine": -w.cosine, "harmonic": w.rate} for w in waves)

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        # less than a period is any curve over position: a spring that stiffens, a stop that is soft
        return scale.shows(values["harmonic"])

    def phenomena(self, values: Mapping[str, float], scale: Scale) -> tuple[str, ...]:
        return self.kin if scale.bends(values["harmonic"]) else ("wave",)

    def ordinary(self, values: Mapping[str, float], scale: Scale) -> bool:
        return scale.ripples(size_of(values))

    def torque(self, torque: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        phase = p["harmonic"] * s.position
        return torque + p["sine"] * ca.sin(phase) + p["cosine"] * ca.cos(phase)
