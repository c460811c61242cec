"""Friction of a grease that motion thins, and that stiffens again at rest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import final

import casadi as ca

from stribeck.model.remembering import RememberingFriction
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States

OLDEST = 2.0  # an arm may have rested since the day before
SHORTEST = 1e-9  # s
WAYS = ((4.0, 0.5), (12.0, 0.3), (4.0, 0.1))  # s, and of the way gone in it, that a fit starts from


@final
class HistoryThixotropy(RememberingFriction):
    """Thixotropy: all friction rises with the structure of a grease, which shear breaks and rest builds up.

    As a contact ages at rest (``dwell_time``), but over seconds, and undone by turns where a contact is renewed by a
    slide of a few millimetres.
    """

    law = "thixotropy"
    equation = r"\tau_f \to \tau_f (1 + a s), \quad \dot s = (1 - s)/T - |v| s / D, \quad s(0) = s_0"
    symptom = "a residual against the motion that is highest after a rest and dies out with the distance gone since"
    source = "Moore (1959); Barnes (1997)"
    parameters = (
        Parameter("change", "1", "relative rise of friction after a long rest", 0.0, -0.9, 10.0),
        Parameter("time", "s", "time over which rest builds up the structure", 5.0, 0.5, 1e4, log=True),
        Parameter("distance", "rad", "distance over which motion breaks it to 1/e", 5.0, 1e-3, 1e5, log=True),
        Parameter("start", "1", "structure with which a recording starts, of that after a long rest", 1.0, 0.0, OLDEST),
    )
    states = ("structure",)
    state_units = MappingProxyType({"structure": "1"})

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        ways = ((time, max(part * time * scale.speed, 2.0 * scale.renews)) for time, part in WAYS)
        return tuple({"change": 0.5, "time": time, "distance": distance, "start": 0.9} for time, distance in ways)

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        return values["distance"] > scale.renews

    def derivatives(self, s: Signals, x: States, p: Parameters) -> dict[str, Expression]:
        built = x["structure"]
        return {"structure": (1.0 - built) / p["time"] - s.slide * built / p["distance"]}

    def initial(self, s: Signals, p: Parameters) -> dict[str, Expression]:
        rate = 1.0 / p["time"] + s.led / ca.fmax(s.lead, SHORTEST) / p["distance"]
        ends = 1.0 / (p["time"] * rate)  # at the mean speed of the part of this recording that came before
        return {"structure": ends + (p["start"] - ends) * ca.exp(-rate * s.lead)}

    def on_average(self, values: Mapping[str, float], starts: Sequence[Signals]) -> dict[str, float]:
        built = [float(self.initial(s, values)["structure"]) for s in starts]
        return {**values, "start": sum(built) / len(built)}
