"""A periodic torque from outside."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import final

import casadi as ca

from stribeck.model.effect import ExternalEffect
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States
from stribeck.model.waves import Trace, tones


@final
class InputDisturbance(ExternalEffect):
    """One sine in time: a machine that shakes the arm.

    It knows nothing of when a recording began: a diagnosis gives each run a clock of its own, and the phase here is
    that of the first one. A disturbance without a period has no law: it counts to the noise floor (`random torque`).
    """

    name = "input_disturbance"
    law = "one_wave"
    channel = "external"
    equation = r"\tau = a \sin 2\pi f t + b \cos 2\pi f t"
    symptom = "a line in the residual's spectrum that depends on time alone, not on pose, motion or torque"
    shows = "frequency"
    waves = 1
    source = "Bodson & Douglas (1997)"
    patternless = True
    parameters = (
        Parameter("sine", "N m", "amplitude of the sine"),
        Parameter("cosine", "N m", "amplitude of the cosine"),
        Parameter("frequency", "Hz", "frequency", 1.0, 0.05, 200.0),
    )

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        size = 0.05 * scale.torque
        return tuple({"sine": size, "cosine": size, "frequency": f} for f in (2.0, 5.0))

    def starts_from(self, scale: Scale, trace: Trace) -> tuple[dict[str, float], ...]:
        waves = tones(trace, (0.3, 25.0), count=2)
        return tuple({"sine": w.sine, "cosine": w.cosine, "frequency": w.rate} for w in waves)

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        return not scale.keeps_time(values["frequency"], self.waves)

    def torque(self, s: Signals, x: States, p: Parameters) -> Expression:
        phase = 2.0 * math.pi * p["frequency"] * s.time
        return p["sine"] * ca.sin(phase) + p["cosine"] * ca.cos(phase)
