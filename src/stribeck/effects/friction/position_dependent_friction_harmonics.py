"""Friction that varies with the joint's position, by more than a pure wave."""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

import casadi as ca
import numpy as np

from stribeck.model.effect import FrictionEffect, Upon
from stribeck.model.scale import UNEVEN, Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States
from stribeck.model.waves import Trace, strongest_waves

WAVES = ("", "second_", "third_")

MOST = 4.0  # cycles a turn of the slowest that are tried without a look at what is left


@final
class PositionDependentFrictionHarmonics(FrictionEffect):
    """A sliding level modulated by three harmonics of the position: a spot that is worn, or a wheel that is bent."""

    name = "position_dependent_friction"
    law = "harmonics"
    channel = "friction"
    upon = Upon.PLACE
    equation = r"G = G_0 \left(1 + \sum_{i=1}^{3} a_i \sin i N q + b_i \cos i N q\right)"
    symptom = "a residual against the direction of motion that is a curve over position"
    shows = "position"
    source = "Armstrong-Helouvry (1991); Popovic & Goldenberg (1998)"
    kin = ("wave",)
    parameters = (
        *(
            Parameter(
                f"{which}{wave}", "1", f"relative amplitude of the {which.replace('_', ' ')}{wave}", 0.0, -2.0, 2.0
            )
            for which in WAVES
            for wave in ("sine", "cosine")
        ),
        Parameter("harmonic", "1/rad", "cycles per turn of the slowest", 1.0, 1.0, 1e6, firm=True),
    )

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return tuple(_from(n) for n in (1.0, 2.0, 3.0, MOST))

    def starts_from(self, scale: Scale, trace: Trace) -> tuple[dict[str, float], ...]:
        way = np.sign(trace.velocity)
        if scale.prismatic:
            waves = strongest_waves(trace.position, way, trace, scale.rates(), 2)
            return tuple(_from(wave.rate / multiple) for wave in waves for multiple in (1.0, 2.0))
        waves = strongest_waves(trace.position, way, trace, (MOST, scale.rates()[1]), 1)
        return (*self.starts(scale), *(_from(wave.rate) for wave in waves))

    def ordinary(self, values: Mapping[str, float], scale: Scale) -> bool:
        return scale.varies(lambda position: _factor(position, values)) < UNEVEN

    def level(self, level: Expression, direction: float, s: Signals, x: States, p: Parameters) -> Expression:
        return ca.fmax(level * _factor(s.position, p), 0.0)


def _factor(position: Expression, p: Parameters) -> Expression:
    factor = 1.0
    for i, which in enumerate(WAVES, 1):
        phase = i * p["harmonic"] * position
        factor += p[f"{which}sine"] * ca.sin(phase) + p[f"{which}cosine"] * ca.cos(phase)
    return factor


def _from(harmonic: float) -> dict[str, float]:
    """Return a start: the derivatives by the amplitudes find the phases."""
    return {**{f"{which}{wave}": 0.05 for which in WAVES for wave in ("sine", "cosine")}, "harmonic": harmonic}
