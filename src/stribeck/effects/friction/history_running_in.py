"""Friction that wears in, or loosens, over the distance gone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import final

import casadi as ca

from stribeck.model.remembering import RememberingFriction
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States

SLOWEST = 2.0  # distances gone in all recordings, over which it may fall to 1/e: slower is another constant level


@final
class HistoryRunningIn(RememberingFriction):
    """Running in: all friction starts at another level and nears its own with the distance, from one run to the next.

    What wears in stays so (kept: 1); grease that a slide spreads has settled again when the next recording starts
    (kept: 0). Of the recordings before, the distance counts together.
    """

    law = "running_in"
    equation = (
        r"\tau_f \to \tau_f (1 + a w), \quad \dot w = -|v| w / L, \quad "
        r"w(0) = 1 \text{ or } 1 - \rho\,(1 - w(\text{before}))"
    )
    symptom = "a residual against the motion that dies out with the distance gone, from one recording to the next"
    source = "Blau (1981); Khonsari, Ghatrehsamani & Akbarzadeh (2021)"
    parameters = (
        Parameter("change", "1", "relative change of friction at the start of the first recording", 0.0, -0.9, 10.0),
        Parameter("distance", "rad", "distance over which it falls to 1/e", 50.0, 1e-3, 1e5, log=True),
        Parameter("kept", "1", "part of it that lasts until the next recording", 1.0, 0.0, 1.0, firm=True),
    )
    states = ("newness",)
    state_units = MappingProxyType({"newness": "1"})

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        ways = ((10.0, 1.0), (60.0, 1.0), (4.0, 0.0))
        return tuple({"change": 0.3, "distance": time * scale.speed, "kept": kept} for time, kept in ways)

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        return scale.renews < values["distance"] < SLOWEST * scale.distance

    def derivatives(self, s: Signals, x: States, p: Parameters) -> dict[str, Expression]:
        return {"newness": -s.slide * x["newness"] / p["distance"]}

    def initial(self, s: Signals, p: Parameters) -> dict[str, Expression]:
        begun = 1.0 - p["kept"] * (1.0 - ca.exp(-s.travelled / p["distance"]))
        return {"newness": begun * ca.exp(-s.led / p["distance"])}

    def on_average(self, values: Mapping[str, float], starts: Sequence[Signals]) -> dict[str, float]:
        newness = [float(self.initial(s, values)["newness"]) for s in starts]
        return {**values, "change": values["change"] * sum(newness) / len(newness)}
