"""Friction that changes with the motion of the last while."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import final

import casadi as ca

from stribeck.model.effect import FrictionEffect, Upon
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States

LEAST = 0.05  # of the level: whatever the warmth, some friction is left
SHORTEST = 1e-9  # s


@final
class History(FrictionEffect):
    """Warm-up: all friction scaled by a state that the joint's own motion charges and time drains.

    Between two recordings a part of it is kept. What a joint brings into one is what all those before it, taken as
    equally long and brisk, have left.
    """

    name = "history"
    law = "warm_up"
    channel = "friction"
    upon = Upon.ALL
    equation = (
        r"\tau_f \to \tau_f (1 + a h), \quad T \dot h = |v| - h, \quad h(0) = h_0 \text{ or } \rho\,h(\text{before})"
    )
    symptom = "a residual against the motion that drifts over a recording, and in part starts anew with the next"
    shows = "time"
    source = "Bittencourt & Gunnarsson (2012); Bittencourt & Axelsson (2014)"
    elusive = True
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

    def level(self, level: Expression, direction: float, s: Signals, x: States, p: Parameters) -> Expression:
        return level * _factor(x, p)

    def viscous(self, torque: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        return torque * _factor(x, p)

    def derivatives(self, s: Signals, x: States, p: Parameters) -> dict[str, Expression]:
        return {"warmth": (s.slide - x["warmth"]) / p["time"]}

    def initial(self, s: Signals, p: Parameters) -> dict[str, Expression]:
        left = p["kept"] * ca.exp(-s.recorded / (ca.fmax(s.recordings, 1.0) * p["time"]))  # of one mean recording
        warmed = (p["kept"] - left) * s.travelled / ca.fmax(s.recorded, SHORTEST)
        again = warmed * (1.0 - left**s.recordings) / (1.0 - left) + left**s.recordings * p["start"]
        first = ca.if_else(s.recordings > 0.0, again, p["start"])
        cools = ca.exp(-s.lead / p["time"])  # in the part of this recording that came before
        return {"warmth": cools * first + (1.0 - cools) * s.led / ca.fmax(s.lead, SHORTEST)}

    def on_average(self, values: Mapping[str, float], starts: Sequence[Signals]) -> dict[str, float]:
        warmth = [float(self.initial(s, values)["warmth"]) for s in starts]
        return {**values, "start": sum(warmth) / len(warmth)}


def _factor(x: States, p: Parameters) -> Expression:
    return ca.fmax(1.0 + p["change"] * x["warmth"], LEAST)
