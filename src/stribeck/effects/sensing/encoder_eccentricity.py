"""Periodic error of an encoder: its disc runs off centre, or it sits before a gear."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import final

import casadi as ca
import numpy as np

from stribeck.model.effect import SensingEffect
from stribeck.model.values import Expression, Parameter, Parameters, Scale
from stribeck.model.waves import Trace, strongest_waves

TURNS = (1.0, 2.0)  # cycles per turn of the joint: off centre, and an oval disc
GEARED = (2.5, 60.0)  # cycles per turn, where the encoder turns faster than the joint
PERIOD = 1.5 * math.pi  # of an error's phase, that must be recorded
SLOPE = 0.5  # that the error may have


@final
class EncoderEccentricity(SensingEffect):
    """A sinusoidal position error with the period of one turn of the joint, a whole part of it, or of the motor."""

    name = "encoder_eccentricity"
    channel = "sensing"
    equation = r"y = q + a \sin N q + b \cos N q"
    symptom = "inertia, velocity and gravity that seem to vary with position"
    shows = "position"
    source = "Ellis (2012), Control System Design Guide, ch. 14 (encoder errors)"
    kin = ("wave",)
    parameters = (
        Parameter("sine", "rad", "amplitude of the sine", 0.0, -0.3, 0.3),
        Parameter("cosine", "rad", "amplitude of the cosine", 0.0, -0.3, 0.3),
        Parameter("harmonic", "1/rad", "cycles per turn: 1 off centre, 2 an oval disc", 1.0, 1.0, 1e6, firm=True),
    )

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return tuple({"sine": 0.005, "cosine": 0.005, "harmonic": n} for n in TURNS)

    def starts_from(self, scale: Scale, trace: Trace) -> tuple[dict[str, float], ...]:
        # a wave of the position has a second derivative that goes with the square of the velocity
        lowest = PERIOD / scale.travel
        rates = scale.rates(1.0) if scale.prismatic else (max(GEARED[0], lowest), max(GEARED[1], 2.0 * lowest))
        waves = strongest_waves(trace.position, trace.velocity**2, trace, rates)
        return (
            *(() if scale.prismatic else self.starts(scale)),
            *(_start(w.sine, w.cosine, w.rate, scale) for w in waves),
        )

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        # nine degrees are more than a disc can run off centre; beyond, it is inertia and gravity that are meant
        size, harmonic = math.hypot(values["sine"], values["cosine"]), values["harmonic"]
        # much less than a period of another wave is any curve over position
        turns = not scale.prismatic and harmonic < TURNS[-1] + 0.2
        seen = turns or harmonic * scale.travel > 0.99 * PERIOD
        return size < 0.15 and size * harmonic < SLOPE and seen

    def measured(self, position: Expression, p: Parameters) -> Expression:
        phase = p["harmonic"] * position
        return position + p["sine"] * ca.sin(phase) + p["cosine"] * ca.cos(phase)


def _start(sine: float, cosine: float, rate: float, scale: Scale) -> dict[str, float]:
    """Return the amplitudes, within bounds, whose inertial torque has these over the squared velocity."""
    per = 1.0 / (scale.inertia * rate**2)
    most = 0.3 * SLOPE / rate
    return {
        "sine": float(np.clip(sine * per, -most, most)),
        "cosine": float(np.clip(cosine * per, -most, most)),
        "harmonic": rate,
    }
