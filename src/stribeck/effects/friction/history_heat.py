"""Friction that its own heat changes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import final

import casadi as ca

from stribeck.model.effect import FrictionEffect, Upon
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States

LEAST = 0.05  # of the level: however warm, some friction is left
SHORTEST = 1e-9  # s
RUNAWAY = 0.8  # of the power, at most, that what it has warmed adds to it: more would have no end


@final
class HistoryHeat(FrictionEffect):
    """Warm-up by work: all friction scaled by a state that friction's own power charges and time drains.

    Where warmth eases friction less power is left to warm it. Between two recordings a part of it is kept. What a joint
    brings into one is what all those before it have left, taken as equally long, at their mean speed.
    """

    name = "history"
    law = "heat"
    channel = "friction"
    upon = Upon.ALL
    uses_friction = True
    equation = (
        r"\tau_f \to \tau_f (1 + a h), \quad T \dot h = |\tau_f v| - h, \quad "
        r"h(0) = h_0 \text{ or } \rho\,h(\text{before})"
    )
    symptom = "a residual against the motion that drifts as friction's own work heats it, and in part starts anew"
    shows = "time"
    source = "Simoni, Beschi, Legnani & Visioli (2015)"
    elusive = True
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

    def level(self, level: Expression, direction: float, s: Signals, x: States, p: Parameters) -> Expression:
        return level * _factor(x, p)

    def viscous(self, torque: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        return torque * _factor(x, p)

    def derivatives(self, s: Signals, x: States, p: Parameters) -> dict[str, Expression]:
        return {"heat": (s.friction * s.slide - x["heat"]) / p["time"]}

    def initial(self, s: Signals, p: Parameters) -> dict[str, Expression]:
        speed, led = s.travelled / ca.fmax(s.recorded, SHORTEST), s.led / ca.fmax(s.lead, SHORTEST)
        power, leading = (self._ends(s.friction * v, p) for v in (speed, led))
        left = p["kept"] * ca.exp(-s.recorded * power[1] / ca.fmax(s.recordings, 1.0))  # of one mean recording
        warmed = (p["kept"] - left) * power[0]
        again = warmed * (1.0 - left**s.recordings) / (1.0 - left) + left**s.recordings * p["start"]
        first = ca.if_else(s.recordings > 0.0, again, p["start"])
        cools = ca.exp(-s.lead * leading[1])  # in the part of this recording that came before
        return {"heat": cools * first + (1.0 - cools) * leading[0]}

    def _ends(self, power: Expression, p: Parameters) -> tuple[Expression, Expression]:
        """Return the warmth (W) in which a steady power ends and how fast it nears that, 1/s."""
        own = 1.0 - ca.fmin(p["change"] * power, RUNAWAY)
        return power / own, own / p["time"]

    def on_average(self, values: Mapping[str, float], starts: Sequence[Signals]) -> dict[str, float]:
        heat = [float(self.initial(s, values)["heat"]) for s in starts]
        return {**values, "start": sum(heat) / len(heat)}


def _factor(x: States, p: Parameters) -> Expression:
    return ca.fmax(1.0 + p["change"] * x["heat"], LEAST)
