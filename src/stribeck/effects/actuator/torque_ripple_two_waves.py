"""Motor constant that varies with the motor's position, with its first overtone."""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

from stribeck.model.effect import ActuatorEffect
from stribeck.model.overtones import size_of, slower_wave, two_waves
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States
from stribeck.model.waves import Trace, strongest_waves


@final
class TorqueRippleTwoWaves(ActuatorEffect):
    """Two harmonics of the torque per current: commutation, flux harmonics, a wavy gear."""

    name = "torque_ripple"
    law = "two_waves"
    channel = "actuator"
    equation = r"\tau = u (1 + a \sin N q + b \cos N q + c \sin 2 N q + d \cos 2 N q)"
    symptom = "a residual that repeats with position, twice over, in proportion to the torque"
    shows = "position"
    source = "Jahns & Soong (1996)"
    kin = ("wave",)
    parameters = (
        Parameter("sine", "1", "relative amplitude of the sine", 0.0, -0.7, 0.7),
        Parameter("cosine", "1", "relative amplitude of the cosine", 0.0, -0.7, 0.7),
        Parameter("second_sine", "1", "relative amplitude of the sine, twice as often", 0.0, -0.4, 0.4),
        Parameter("second_cosine", "1", "relative amplitude of the cosine, twice as often", 0.0, -0.4, 0.4),
        Parameter("harmonic", "1/rad", "cycles per turn of the slower wave", 1.0, 1.0, 1e6),
    )

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        seen = 7.0 / scale.travel  # a period of them
        return tuple(slower_wave(0.05, 0.05, max(n, seen)) for n in (4.0, 6.0, 12.0))

    def starts_from(self, scale: Scale, trace: Trace) -> tuple[dict[str, float], ...]:
        waves = strongest_waves(trace.position, trace.command, trace, scale.rates(), 1)
        return tuple(slower_wave(_inside(-w.sine), _inside(-w.cosine), w.rate) for w in waves)

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        # less than a period is any gain that changes with position
        return scale.driven and scale.shows(values["harmonic"])

    def ordinary(self, values: Mapping[str, float], scale: Scale) -> bool:
        return scale.ripples(size_of(values) * scale.torque)

    def torque(self, torque: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        return torque * self.command_scale(s.position, p)

    def command_scale(self, position: Expression, p: Parameters) -> Expression:
        return 1.0 + two_waves(p["harmonic"] * position, p)


def _inside(amplitude: float) -> float:
    return float(min(max(amplitude, -0.6), 0.6))
