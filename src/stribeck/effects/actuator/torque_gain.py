"""Wrong torque constant."""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

from stribeck.model.effect import ActuatorEffect
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States


@final
class TorqueGain(ActuatorEffect):
    """The motor gives a constant multiple of the commanded torque."""

    name = "torque_gain"
    channel = "actuator"
    equation = r"\tau = g\,u"
    symptom = "inertia, gravity and friction all seem scaled by the same factor"
    shows = "command"
    source = "Gautier & Briot (2014), identification of drive gains"
    rescales = True
    parameters = (Parameter("gain", "1", "torque per commanded torque", 1.0, 0.4, 2.5),)

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return ({"gain": 0.9}, {"gain": 1.1})

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        return scale.driven  # of nothing any multiple is as much, but fewer units are left

    def torque(self, torque: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        return p["gain"] * torque

    def command_scale(self, position: Expression, p: Parameters) -> Expression:
        return p["gain"]
