"""Periodic error of an encoder with its first overtone: an unbalanced resolver, a disc off centre and oval."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import final

import numpy as np

from stribeck.model.discs import STEEPEST, as_any_reads, discs, is_of_a_disc, waves_of_discs
from stribeck.model.effect import SensingEffect
from stribeck.model.overtones import faster_wave, size_of, slower_wave, two_waves
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters
from stribeck.model.waves import Trace


@final
class EncoderEccentricityTwoWaves(SensingEffect):
    """A position error with the period of a turn of the joint or of the motor, and with half of it."""

    name = "encoder_eccentricity"
    law = "two_waves"
    channel = "sensing"
    equation = r"y = q + a \sin N q + b \cos N q + c \sin 2 N q + d \cos 2 N q"
    symptom = "inertia, velocity and gravity that seem to vary with position, twice over"
    shows = "position"
    source = "Ellis (2012), Control System Design Guide, ch. 14 (resolver errors once and twice per turn)"
    kin = ("wave",)
    parameters = (
        Parameter("sine", "rad", "amplitude of the sine", 0.0, -0.3, 0.3),
        Parameter("cosine", "rad", "amplitude of the cosine", 0.0, -0.3, 0.3),
        Parameter("second_sine", "rad", "amplitude of the sine, twice as often", 0.0, -0.3, 0.3),
        Parameter("second_cosine", "rad", "amplitude of the cosine, twice as often", 0.0, -0.3, 0.3),
        Parameter("harmonic", "1/rad", "cycles per turn of the slower wave", 1.0, 1.0, 1e6, firm=True),
    )

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return tuple(slower_wave(wave.sine, wave.cosine, wave.rate) for wave in discs()[:1])

    def starts_from(self, scale: Scale, trace: Trace) -> tuple[dict[str, float], ...]:
        # the strongest wave may be either one of the two
        strongest = waves_of_discs(scale, trace, 1)[-1]
        wave = (strongest.sine, strongest.cosine, strongest.rate)
        return (*(() if scale.prismatic else self.starts(scale)), slower_wave(*wave), faster_wave(*wave))

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        first = math.hypot(values["sine"], values["cosine"])
        second = math.hypot(values["second_sine"], values["second_cosine"])
        rate = values["harmonic"]
        return is_of_a_disc(first, rate, scale) and is_of_a_disc(second, 2.0 * rate, scale)

    def ordinary(self, values: Mapping[str, float], scale: Scale) -> bool:
        return as_any_reads(size_of(values), scale)

    def measured(self, position: Expression, p: Parameters) -> Expression:
        return position + two_waves(p["harmonic"] * position, p)

    def folds(self, values: Mapping[str, float]) -> bool:
        phase = np.linspace(0.0, 2.0 * math.pi, 1000)
        first = values["sine"] * np.cos(phase) - values["cosine"] * np.sin(phase)
        second = values["second_sine"] * np.cos(2.0 * phase) - values["second_cosine"] * np.sin(2.0 * phase)
        return bool(np.max(-values["harmonic"] * (first + 2.0 * second)) > STEEPEST)
