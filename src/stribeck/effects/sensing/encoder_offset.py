"""A zero of the encoder that is not where the model has it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, final

from stribeck.model.effect import SensingEffect
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters

HOMED = 0.02  # rad, within which any encoder is homed, and any centre of mass known to lie on its link's line


@final
class EncoderOffset(SensingEffect):
    """A constant position error: wrong homing or calibration."""

    name = "encoder_offset"
    channel = "sensing"
    counted = True
    equation = r"y = q + q_0"
    symptom = "gravity (and the coupling of the joints) that seems rotated by a constant angle"
    shows = "position"
    source = "Khalil & Dombre (2002), ch. 11 (geometric calibration)"
    parameters = (Parameter("offset", "rad", "recorded less true position", 0.0, -math.pi, math.pi),)

    def applies(self, arm: Any, joint: int) -> bool:
        # without gravity the first joint's angle has no zero, and an axis that slides has none at all
        weighs = math.hypot(*arm.gravity) > 0.0
        return bool(arm.joints[joint].kind == "revolute" and (weighs or joint > 0))

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return ({"offset": 0.03},)

    def ordinary(self, values: Mapping[str, float], scale: Scale) -> bool:
        return abs(values["offset"]) < HOMED

    def measured(self, position: Expression, p: Parameters) -> Expression:
        return position + p["offset"]
