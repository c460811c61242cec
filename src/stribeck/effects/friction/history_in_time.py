"""Friction that settles as time goes by, however the joint moves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import final

import casadi as ca

from stribeck.model.remembering import RememberingFriction
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States

SLOWEST = 2.0  # times that all recordings last, over which it may fall to 1/e: slower is another constant level
TINY = 1e-9


@final
class HistoryInTime(RememberingFriction):
    """Settling: all friction starts at another level and nears its own with time, as a drive that is on grows warm.

    Between two recordings a part of what has settled is kept. Those before count as equally long.
    """

    law = "in_time"
    equation = (
        r"\tau_f \to \tau_f (1 + a w), \quad \dot w = -w / T, \quad "
        r"w(0) = 1 \text{ or } 1 - \rho\,(1 - w(\text{before}))"
    )
    symptom = "a residual against the motion that dies out with time, and in part starts anew with the next recording"
    source = "Bittencourt & Gunnarsson (2012); Bittencourt & Axelsson (2014)"
    parameters = (
        Parameter("change", "1", "relative change of friction at the start of the first recording", 0.0, -0.9, 10.0),
        Parameter("time", "s", "time over which it falls to 1/e", 20.0, 0.5, 1e4, log=True),
        Parameter(
            "kept", "1", "part of what has settled that lasts until the next recording", 0.5, 0.0, 1.0, firm=True
        ),
    )
    states = ("newness",)
    state_units = MappingProxyType({"newness": "1"})

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        ways = ((4.0, 0.0), (15.0, 0.5), (40.0, 1.0))
        return tuple({"change": 0.3, "time": time, "kept": kept} for time, kept in ways)

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        return values["time"] < SLOWEST * scale.distance / scale.speed

    def derivatives(self, s: Signals, x: States, p: Parameters) -> dict[str, Expression]:
        return {"newness": -x["newness"] / p["time"]}

    def initial(self, s: Signals, p: Parameters) -> dict[str, Expression]:
        fades = ca.exp(-s.recorded / (ca.fmax(s.recordings, 1.0) * p["time"]))  # in one mean recording
        stays = ca.fmax(p["kept"] * fades, TINY)
        settled = p["kept"] * (1.0 - fades) * (1.0 - stays**s.recordings) / ca.fmax(1.0 - stays, TINY)
        return {"newness": (1.0 - settled) * ca.exp(-s.lead / p["time"])}

    def on_average(self, values: Mapping[str, float], starts: Sequence[Signals]) -> dict[str, float]:
        newness = [float(self.initial(s, values)["newness"]) for s in starts]
        return {**values, "change": values["change"] * sum(newness) / len(newness)}
