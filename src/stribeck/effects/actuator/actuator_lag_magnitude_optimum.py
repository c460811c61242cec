"""Lag of the torque behind its command, as a tuned current loop has it."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import final

from stribeck.model.effect import ActuatorEffect, Along
from stribeck.model.scale import PROMPT, Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States


@final
class ActuatorLagMagnitudeOptimum(ActuatorEffect):
    """Two complex poles, damped by 0.71: a current loop whose controller is set by the magnitude optimum.

    Up to its bandwidth it is as late at all frequencies, nearly as a delay is.
    """

    name = "actuator_lag"
    law = "magnitude_optimum"
    channel = "actuator"
    along = Along.CURRENT
    equation = r"\frac{T^2}{2} \ddot\tau + T \dot\tau + \tau = u"
    symptom = "a residual in proportion to the rate of the command, and to its second derivative where that is fast"
    shows = "command rate"
    source = "Kessler (1955); Umland & Safiuddin (1990), magnitude and symmetric optimum"
    kin = ("late",)
    filters = True
    parameters = (Parameter("time_constant", "s", "lateness at low frequency", 0.0, 1e-5, 0.5),)
    states = ("torque", "ahead")
    state_units = MappingProxyType({"torque": "N m", "ahead": "N m"})

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return ({"time_constant": 0.01},)

    def ordinary(self, values: Mapping[str, float], scale: Scale) -> bool:
        return values["time_constant"] < PROMPT

    def torque(self, torque: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        return x["torque"]

    def derivatives(self, s: Signals, x: States, p: Parameters) -> dict[str, Expression]:
        torque, ahead = x["torque"], x["ahead"]  # of the torque, by what its rate makes in the time constant
        pulls = {"torque": ahead - torque, "ahead": 2.0 * s.torque - torque - ahead}
        return {name: pull / p["time_constant"] for name, pull in pulls.items()}

    def initial(self, s: Signals, p: Parameters) -> dict[str, Expression]:
        return dict.fromkeys(self.states, s.torque)
