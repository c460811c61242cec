"""Friction that varies with the joint's position."""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

import casadi as ca
import numpy as np

from stribeck.model.effect import FrictionEffect, Upon
from stribeck.model.scale import UNEVEN, Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States
from stribeck.model.waves import Trace, strongest_waves

MOST = 12.0  # cycles a turn that are tried without a look at what is left


@final
class PositionDependentFriction(FrictionEffect):
    """A sliding level modulated by one harmonic of the position."""

    name = "position_dependent_friction"
    law = "one_wave"
    channel = "friction"
    upon = Upon.PLACE
    equation = r"G = G_0 (1 + a \sin N q + b \cos N q)"
    symptom = "a residual against the direction of motion that repeats with position"
    shows = "position"
    source = "Armstrong-Helouvry (1991); Popovic & Goldenberg (1998)"
    kin = ("wave",)
    parameters = (
        Parameter("sine", "1", "relative amplitude of the sine", 0.0, -2.0, 2.0),
        Parameter("cosine", "1", "relative amplitude of the cosine", 0.0, -2.0, 2.0),
        Parameter("harmonic", "1/rad", "cycles per turn", 1.0, 1.0, 1e6, firm=True),
    )

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        # one trial a harmonic: the derivatives by both amplitudes find the phase
        return tuple({"sine": 0.05, "cosine": 0.05, "harmonic": n} for n in (1.0, 2.0, 3.0, 4.0, 6.0, 8.0, MOST))

    def starts_from(self, scale: Scale, trace: Trace) -> tuple[dict[str, float], ...]:
        # beyond those of a few a turn, the one that a gear's fast side would make
        rates, count = (scale.rates(), 3) if scale.prismatic else ((MOST, scale.rates()[1]), 1)
        waves = strongest_waves(trace.position, np.sign(trace.velocity), trace, rates, count)
        size = max(scale.friction, 0.02 * scale.torque)
        found = tuple(
            {"sine": _inside(w.sine / size), "cosine": _inside(w.cosine / size), "harmonic": w.rate} for w in waves
        )
        return found if scale.prismatic else (*self.starts(scale), *found)

    def ordinary(self, values: Mapping[str, float], scale: Scale) -> bool:
        return scale.varies(lambda position: _factor(position, values)) < UNEVEN

    def level(self, level: Expression, direction: float, s: Signals, x: States, p: Parameters) -> Expression:
        return ca.fmax(level * _factor(s.position, p), 0.0)


def _factor(position: Expression, p: Parameters) -> Expression:
    phase = p["harmonic"] * position
    return 1.0 + p["sine"] * ca.sin(phase) + p["cosine"] * ca.cos(phase)


def _inside(amplitude: float) -> float:
    return float(min(max(amplitude, -1.0), 1.0))
