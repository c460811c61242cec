"""Once-per-turn error of an encoder whose disc runs off centre."""

from __future__ import annotations

from typing import final

import casadi as ca

from stribeck.model.effect import Expression, Parameter, Parameters, Scale, SensingEffect


@final
class EncoderEccentricity(SensingEffect):
    """A sinusoidal position error with the period of one turn."""

    name = "encoder_eccentricity"
    channel = "sensing"
    equation = r"y = q + a \sin q + b \cos q"
    symptom = "inertia, velocity and gravity that seem to vary with position, once per turn"
    source = "Alejandre & Artes (2006)"
    parameters = (
        Parameter("sine", "rad", "amplitude of the sine", 0.0, -0.3, 0.3),
        Parameter("cosine", "rad", "amplitude of the cosine", 0.0, -0.3, 0.3),
    )

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return ({"sine": 0.01, "cosine": 0.0}, {"sine": 0.0, "cosine": 0.01})

    def measured(self, position: Expression, p: Parameters) -> Expression:
        return position + p["sine"] * ca.sin(position) + p["cosine"] * ca.cos(position)
