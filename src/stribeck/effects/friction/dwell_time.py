"""Static friction that grows with the time at rest."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import final

import casadi as ca

from stribeck.model.effect import FrictionEffect
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States

OLDEST = 2.0  # an arm may have rested since the day before


@final
class DwellTime(FrictionEffect):
    """Contacts that age at rest and are renewed by sliding; the state is their age between 0 and 1.

    An arm has rested before it is recorded, for how long no record says: the first break-away does.
    """

    name = "dwell_time"
    law = "break_away"
    channel = "friction"
    equation = r"C_1 \to C_1 + A a, \quad \dot a = (1 - a)/T - a |v|/D"
    symptom = "a break-away torque that grows with the rest before it and is gone after a short slide"
    shows = "start"
    source = "Rabinowicz (1958); Dieterich (1979); Armstrong-Helouvry, Dupont & Canudas de Wit (1994)"
    kin = ("rest",)
    elusive = True
    parameters = (
        Parameter("rise", "N m", "rise of the break-away torque after a long rest", 0.0, 0.0),
        Parameter("time", "s", "time over which it rises", 1.0, 0.1, 1e3, log=True),
        Parameter("distance", "rad", "slide that renews the contact", 0.01, 1e-4, 10.0, log=True, firm=True),
        Parameter("start", "1", "age at which a recording starts, of that after a long rest", 0.0, 0.0, OLDEST),
    )
    states = ("age",)

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        size = 0.5 * max(scale.friction, 0.02 * scale.torque)
        distances = (min(max(part * scale.travel, 2e-3), 0.5 * scale.renews) for part in (0.003, 0.01))
        return tuple({"rise": size, "time": 0.7, "distance": distance, "start": 0.5} for distance in distances)

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        # a high one that any slide renews at once is friction that falls as 1 / v
        risen = -values["rise"] * math.expm1(-1.0 / values["time"])  # in a second
        return risen < scale.rises and values["distance"] < scale.renews

    def constants(self, constants: Parameters, s: Signals, x: States, p: Parameters) -> Parameters:
        return {**constants, "C1": constants["C1"] + p["rise"] * x["age"]}

    def derivatives(self, s: Signals, x: States, p: Parameters) -> dict[str, Expression]:
        a = x["age"]
        return {"age": (1.0 - a) / p["time"] - s.slide * a / p["distance"]}

    def initial(self, s: Signals, p: Parameters) -> dict[str, Expression]:
        return {"age": ca.if_else(s.lead > 0.0, 0.0, p["start"])}
