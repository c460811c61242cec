"""Friction that its own heat changes."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import final

import casadi as ca

from stribeck.model.remembering import WarmedFriction
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States

RUNAWAY = 0.8  # of the power, at most, that what it has warmed adds to it: more would have no end


@final
class HistoryHeat(WarmedFriction):
    """Warm-up by work: all friction scaled by a state that friction's own power charges and time drains.

    Where warmth eases friction less power is left to warm it. Between two recordings a part of it is kept. What a joint
    brings into one is what all those before it have left, taken as equally long, at their mean speed.
    """

    law = "heat"
    uses_friction = True
    equation = (
        r"\tau_f \to \tau_f (1 + a h), \quad T \dot h = |\tau_f v| - h, \quad "
        r"h(0) = h_0 \text{ or } \rho\,h(\text{before})"
    )
    symptom = "a residual against the motion that drifts as friction's own work heats it, and in part starts anew"
    source = "Simoni, Beschi, Legnani & Visioli (2015)"
    parameters = (
        Parameter("change", "1/W", "relative change of friction per mean power of its own", 0.0, -1e6, 1e6),
        Parameter("time", "s", "time over which the past is forgotten", 20.0, 0.5, 1e4, log=True),
        Parameter("start", "W", "mean power before the first recording", 0.0, 0.0, 1e5),
        Parameter("kept", "1", "part that is left of it when the next recording starts", 0.0, 0.0, 1.0),
    )
    states = ("heat",)
    state_units = MappingProxyType({"heat": "W"})

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        power = max(scale.friction, 0.02 * scale.torque) * scale.speed
        return tuple(
            {"change": change / power, "time": time, "start": 0.1 * power, "kept": 0.4}
            for change, time in ((0.3, 5.0), (0.3, 25.0), (-0.3, 25.0))
        )

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        return values["change"] * scale.friction * scale.speed < RUNAWAY

    def derivatives(self, s: Signals, x: States, p: Parameters) -> dict[str, Expression]:
        return {"heat": (s.friction * s.slide - x["heat"]) / p["time"]}

    def nears(self, speed: Expression, s: Signals, p: Parameters) -> tuple[Expression, Expression]:
        power = s.friction * speed
        own = 1.0 - ca.fmin(p["change"] * power, RUNAWAY)
        return power / own, own / p["time"]
