"""Pure delay of the torque behind its command."""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

from stribeck.model.effect import ActuatorEffect, Along
from stribeck.model.scale import PROMPT, Scale
from stribeck.model.values import Parameter


@final
class Delay(ActuatorEffect):
    """A transport delay: computation, bus and drive. The machinery delays the command itself."""

    name = "delay"
    channel = "actuator"
    along = Along.COMMAND
    equation = r"\tau(t) = u(t - T)"
    symptom = "a residual in proportion to the rate of the command, with a phase that grows with frequency"
    shows = "command rate"
    source = "paper, section 5 (communication delay)"
    kin = ("late",)
    filters = True
    parameters = (Parameter("time", "s", "delay", 0.0, 0.0, 0.2),)
    delays = "command"

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return ({"time": 0.01},)

    def ordinary(self, values: Mapping[str, float], scale: Scale) -> bool:
        return values["time"] < PROMPT
