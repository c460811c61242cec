"""Motor constant that varies with the motor's position."""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

import casadi as ca

from stribeck.model.effect import ActuatorEffect
from stribeck.model.overtones import size_of
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States
from stribeck.model.waves import Trace, strongest_waves


@final
class TorqueRipple(ActuatorEffect):
    """One harmonic of the torque per current: commutation, flux harmonics, a wavy gear."""

    name = "torque_ripple"
    law = "one_wave"
    channel = "actuator"
    equation = r"\tau = u (1 + a \sin N q + b \cos N q)"
    symptom = "a residual that repeats with position in proportion to the torque"
    shows = "position"
    source = "Jahns & Soong (1996)"
    kin = ("wave",)
    parameters = (
        Parameter("sine", "1", "relative amplitude of the sine", 0.0, -0.7, 0.7),
        Parameter("cosine", "1", "relative amplitude of the cosine", 0.0, -0.7, 0.7),
        Parameter("harmonic", "1/rad", "cycles per turn", 1.0, 1.0, 1e6),
    )

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        seen = 7.0 / scale.travel  # a period of them
        return tuple({"sine": 0.05, "cosine": 0.05, "harmonic": max(n, seen)} for n in (4.0, 6.0, 8.0, 12.0))

    def starts_from(self, scale: Scale, trace: Trace) -> tuple[dict[str, float], ...]:
        waves = strongest_waves(trace.position, trace.command, trace, scale.rates())
        return tuple({"sine": _inside(-w.sine), "cosine": _inside(-w.cosine), "harmonic": w.rate} for w in waves)

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        # less than a period is any gain that changes with position
        return scale.driven and scale.shows(values["harmonic"])

    def ordinary(self, values: Mapping[str, float], scale: Scale) -> bool:
        return scale.ripples(size_of(values) * scale.torque)

    def torque(self, torque: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        return torque * self.command_scale(s.position, p)

    def command_scale(self, position: Expression, p: Parameters) -> Expression:
        phase = p["harmonic"] * position
        return 1.0 + p["sine"] * ca.sin(phase) + p["cosine"] * ca.cos(phase)


def _inside(amplitude: float) -> float:
    return float(min(max(amplitude, -0.6), 0.6))
