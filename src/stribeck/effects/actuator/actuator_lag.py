"""First-order lag of the torque behind its command."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import final

from stribeck.model.effect import ActuatorEffect, Along
from stribeck.model.scale import PROMPT, Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States


@final
class ActuatorLag(ActuatorEffect):
    """The bandwidth of a current loop or a drive, as one pole."""

    name = "actuator_lag"
    law = "one_pole"
    channel = "actuator"
    along = Along.CURRENT
    equation = r"T \dot\tau = u - \tau"
    symptom = "a residual in proportion to the rate of the command"
    shows = "command rate"
    source = "paper, section 5 (actuator dynamics); Ellis (2012), Control System Design Guide (current loops)"
    kin = ("late",)
    filters = True
    parameters = (Parameter("time_constant", "s", "time constant", 0.0, 1e-5, 0.5),)
    states = ("torque",)
    state_units = MappingProxyType({"torque": "N m"})

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return ({"time_constant": 0.01},)

    def ordinary(self, values: Mapping[str, float], scale: Scale) -> bool:
        return values["time_constant"] < PROMPT

    def torque(self, torque: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        return x["torque"]

    def derivatives(self, s: Signals, x: States, p: Parameters) -> dict[str, Expression]:
        return {"torque": (s.torque - x["torque"]) / p["time_constant"]}

    def initial(self, s: Signals, p: Parameters) -> dict[str, Expression]:
        return {"torque": s.torque}
