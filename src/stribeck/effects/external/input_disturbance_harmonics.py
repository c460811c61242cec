"""A periodic torque from outside that is no pure wave: pulses, a square, a saw-tooth."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import final

import casadi as ca

from stribeck.model.effect import ExternalEffect
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States
from stribeck.model.waves import Trace, tones

ORDER = ("", "second_", "third_")  # prefixes of the harmonics' amplitudes


@final
class InputDisturbanceHarmonics(ExternalEffect):
    """The first three harmonics of a periodic torque: of pulses and squares they hold 85 to 90 % of the power.

    What holds for the clock of a single wave holds here as well.
    """

    name = "input_disturbance"
    law = "harmonics"
    channel = "external"
    equation = r"\tau = \sum_{i=1}^{3} a_i \sin 2\pi i f t + b_i \cos 2\pi i f t"
    symptom = (
        "a line in the residual's spectrum, and lines at two and three times its frequency, that depend on time alone"
    )
    shows = "frequency"
    waves = len(ORDER)
    source = "Bodson & Douglas (1997); Fourier series"
    patternless = True
    parameters = (
        *(
            Parameter(f"{order}{part}", "N m", f"amplitude of the {order.replace('_', ' harmonic, ')}{part}")
            for order in ORDER
            for part in ("sine", "cosine")
        ),
        Parameter("frequency", "Hz", "frequency of the first harmonic", 1.0, 0.05, 200.0),
    )

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        size = 0.05 * scale.torque
        return tuple(_start(size, size, f) for f in (2.0, 5.0))

    def starts_from(self, scale: Scale, trace: Trace) -> tuple[dict[str, float], ...]:
        waves = tones(trace, (0.1, 25.0), count=1)
        return tuple(_start(w.sine, w.cosine, w.rate) for w in waves)

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        return not scale.keeps_time(values["frequency"], self.waves)

    def torque(self, s: Signals, x: States, p: Parameters) -> Expression:
        phase = 2.0 * math.pi * p["frequency"] * s.time
        terms = (
            p[f"{order}sine"] * ca.sin(i * phase) + p[f"{order}cosine"] * ca.cos(i * phase)
            for i, order in enumerate(ORDER, 1)
        )
        return sum(terms)


def _start(sine: float, cosine: float, frequency: float) -> dict[str, float]:
    parts = {f"{order}{part}": 0.0 for order in ORDER for part in ("sine", "cosine")}
    return parts | {"sine": sine, "cosine": cosine, "frequency": frequency}
