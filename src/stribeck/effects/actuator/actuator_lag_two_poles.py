"""Second-order lag of the torque behind its command."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import final

from stribeck.model.effect import ActuatorEffect, Along
from stribeck.model.scale import PROMPT, Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States


@final
class ActuatorLagTwoPoles(ActuatorEffect):
    """Two equal poles: a current loop behind a filter of its set-point, or a loop that is critically damped."""

    name = "actuator_lag"
    law = "two_poles"
    channel = "actuator"
    along = Along.CURRENT
    equation = r"\frac{T}{2} \dot w = u - w, \quad \frac{T}{2} \dot\tau = w - \tau"
    symptom = "a residual in proportion to the rate of the command, and to its second derivative where that is fast"
    shows = "command rate"
    source = "Ellis (2012), Control System Design Guide (current loops, command filters)"
    kin = ("late",)
    filters = True
    parameters = (Parameter("time_constant", "s", "time constants of both poles together", 0.0, 1e-5, 0.5),)
    states = ("filtered", "torque")
    state_units = MappingProxyType({"filtered": "N m", "torque": "N m"})

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return ({"time_constant": 0.01},)

    def ordinary(self, values: Mapping[str, float], scale: Scale) -> bool:
        return values["time_constant"] < PROMPT

    def torque(self, torque: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        return x["torque"]

    def derivatives(self, s: Signals, x: States, p: Parameters) -> dict[str, Expression]:
        rate = 2.0 / p["time_constant"]
        return {"filtered": rate * (s.torque - x["filtered"]), "torque": rate * (x["filtered"] - x["torque"])}

    def initial(self, s: Signals, p: Parameters) -> dict[str, Expression]:
        return dict.fromkeys(self.states, s.torque)
