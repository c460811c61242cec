"""Once-per-turn error of an encoder whose disc runs off centre."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import final

import casadi as ca

from stribeck.model.effect import SensingEffect
from stribeck.model.values import Expression, Parameter, Parameters, Scale


@final
class EncoderEccentricity(SensingEffect):
    """A sinusoidal position error with the period of one turn, or a whole part of it."""

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
        Parameter("harmonic", "1/rad", "cycles per turn: 1 off centre, 2 with an oval disc", 1.0, 1.0, 8.0, firm=True),
    )

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return tuple({"sine": 0.005, "cosine": 0.005, "harmonic": n} for n in (1.0, 2.0))

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        # nine degrees are more than a disc can run off centre; beyond, it is inertia and gravity that are meant
        return math.hypot(values["sine"], values["cosine"]) < 0.15

    def measured(self, position: Expression, p: Parameters) -> Expression:
        phase = p["harmonic"] * position
        return position + p["sine"] * ca.sin(phase) + p["cosine"] * ca.cos(phase)
