"""Torque of the motor that is periodic in its position, with its first overtone."""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

import numpy as np

from stribeck.model.effect import ActuatorEffect, Along
from stribeck.model.overtones import size_of, slower_wave, two_waves
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States
from stribeck.model.waves import Trace, strongest_waves


@final
class CoggingTwoWaves(ActuatorEffect):
    """Two harmonics of the pull of the magnets on the slots: it is seldom a pure sine."""

    name = "cogging"
    law = "two_waves"
    channel = "actuator"
    along = Along.IRON
    equation = r"\tau = u + a \sin N q + b \cos N q + c \sin 2 N q + d \cos 2 N q"
    symptom = "a residual that repeats with position, twice over, of the same sign in both directions and at rest"
    shows = "position"
    source = "Jahns & Soong (1996); Hanselman (2006)"
    kin = ("wave", "curve")
    parameters = (
        Parameter("sine", "N m", "amplitude of the sine"),
        Parameter("cosine", "N m", "amplitude of the cosine"),
        Parameter("second_sine", "N m", "amplitude of the sine, twice as often"),
        Parameter("second_cosine", "N m", "amplitude of the cosine, twice as often"),
        Parameter("harmonic", "1/rad", "cycles per turn of the slower wave", 1.0, 1.0, 1e6),
    )

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        size = 0.05 * scale.torque
        seen = 7.0 / scale.travel  # a period of them
        return tuple(slower_wave(size, size, max(n, seen)) for n in (4.0, 6.0, 12.0))

    def starts_from(self, scale: Scale, trace: Trace) -> tuple[dict[str, float], ...]:
        waves = strongest_waves(trace.position, np.ones_like(trace.position), trace, scale.rates(), 1)
        return tuple(slower_wave(-w.sine, -w.cosine, w.rate) for w in waves)

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        # less than a period is any curve over position: a spring that stiffens, a stop that is soft
        return scale.shows(values["harmonic"])

    def phenomena(self, values: Mapping[str, float], scale: Scale) -> tuple[str, ...]:
        return self.kin if scale.bends(values["harmonic"]) else ("wave",)

    def ordinary(self, values: Mapping[str, float], scale: Scale) -> bool:
        return scale.ripples(size_of(values))

    def torque(self, torque: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        return torque + two_waves(p["harmonic"] * s.position, p)
