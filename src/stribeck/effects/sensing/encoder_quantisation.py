"""An encoder that counts in coarser steps than the arm file says."""

from __future__ import annotations

import math
from typing import final

from stribeck.model.effect import SensingEffect
from stribeck.model.scale import Scale
from stribeck.model.values import Observed, Parameter, Record
from stribeck.quantum import smallest_step

COARSER = 1.5  # than the arm file's resolution
COARSE = 2.0 * math.pi / 4000  # rad, where the arm file has none: below twelve bits an encoder is news
COARSE_SCALE = 1e-4  # m, of an axis that slides


@final
class EncoderQuantisation(SensingEffect):
    """Positions come in whole steps; the records show the step, and no torque does.

    The cut takes the smoothed positions for true, and a simulated position is left unrounded: the step enters the
    noise floor instead.
    """

    name = "encoder_quantisation"
    channel = "sensing"
    equation = r"y = \Delta \, \mathrm{round}(q / \Delta)"
    symptom = "positions on a coarse grid; noise in velocity and acceleration that grows when the joint is slow"
    shows = "recorded position"
    source = "Widrow & Kollar (2008), Quantization Noise"
    parameters = (Parameter("resolution", "rad", "step of the encoder", 0.0, 0.0, 1.0),)
    direct = True

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return ({"resolution": 1e-3 * scale.travel},)

    def observed(self, record: Record) -> Observed | None:
        step, off = smallest_step(*(record.read or record.position))
        if step > self.parameters[0].upper:
            return None  # counts, or degrees
        coarse = COARSE_SCALE if record.prismatic else COARSE
        if step <= (COARSER * record.resolution if record.resolution else coarse):
            return None
        return Observed({"resolution": (step, step - off, step + off)}, 1.0)
