"""Periodic error of an encoder: its disc runs off centre, or it sits before a gear."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import final

import casadi as ca

from stribeck.model.discs import STEEPEST, as_any_reads, discs, is_of_a_disc, waves_of_discs
from stribeck.model.effect import SensingEffect
from stribeck.model.overtones import size_of
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters
from stribeck.model.waves import Trace, Wave


@final
class EncoderEccentricity(SensingEffect):
    """A sinusoidal position error with the period of one turn of the joint, a whole part of it, or of the motor."""

    name = "encoder_eccentricity"
    law = "one_wave"
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
        return tuple(map(_start, discs()))

    def starts_from(self, scale: Scale, trace: Trace) -> tuple[dict[str, float], ...]:
        return tuple(map(_start, waves_of_discs(scale, trace)))

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        return is_of_a_disc(math.hypot(values["sine"], values["cosine"]), values["harmonic"], scale)

    def ordinary(self, values: Mapping[str, float], scale: Scale) -> bool:
        return as_any_reads(size_of(values), scale)

    def measured(self, position: Expression, p: Parameters) -> Expression:
        phase = p["harmonic"] * position
        return position + p["sine"] * ca.sin(phase) + p["cosine"] * ca.cos(phase)

    def folds(self, values: Mapping[str, float]) -> bool:
        return values["harmonic"] * math.hypot(values["sine"], values["cosine"]) > STEEPEST


def _start(wave: Wave) -> dict[str, float]:
    return {"sine": wave.sine, "cosine": wave.cosine, "harmonic": wave.rate}
