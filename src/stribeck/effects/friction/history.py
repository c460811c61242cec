"""Friction that changes with the motion of the last while."""

from __future__ import annotations

from types import MappingProxyType
from typing import final

from stribeck.model.remembering import WarmedFriction
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States


@final
class History(WarmedFriction):
    """Warm-up: all friction scaled by a state that the joint's own motion charges and time drains.

    Between two recordings a part of it is kept. What a joint brings into one is what all those before it, taken as
    equally long and brisk, have left.
    """

    law = "warm_up"
    equation = (
        r"\tau_f \to \tau_f (1 + a h), \quad T \dot h = |v| - h, \quad h(0) = h_0 \text{ or } \rho\,h(\text{before})"
    )
    symptom = "a residual against the motion that drifts over a recording, and in part starts anew with the next"
    source = "Bittencourt & Gunnarsson (2012); Bittencourt & Axelsson (2014)"
    parameters = (
        Parameter("change", "s/rad", "relative change of friction per mean speed", 0.0, -1e3, 1e3),
        Parameter("time", "s", "time over which the past is forgotten", 20.0, 0.5, 1e4, log=True),
        Parameter("start", "rad/s", "mean speed before the first recording", 0.0, 0.0, 1e2),
        Parameter("kept", "1", "part that is left of it when the next recording starts", 0.0, 0.0, 1.0),
    )
    states = ("warmth",)
    state_units = MappingProxyType({"warmth": "rad/s"})

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return tuple(
            {"change": 0.3 / scale.speed, "time": time, "start": 0.1 * scale.speed, "kept": 0.4} for time in (5.0, 25.0)
        )

    def derivatives(self, s: Signals, x: States, p: Parameters) -> dict[str, Expression]:
        return {"warmth": (s.slide - x["warmth"]) / p["time"]}

    def nears(self, speed: Expression, s: Signals, p: Parameters) -> tuple[Expression, Expression]:
        return speed, 1.0 / p["time"]
