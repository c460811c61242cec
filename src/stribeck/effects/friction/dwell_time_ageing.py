"""A contact that ages at rest, and is renewed by slip alone."""

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
class DwellTimeAgeing(FrictionEffect):
    """The whole level rises with the age, at any speed, until the contact has slipped far enough to be new.

    The break-away law lets the rise fall off with the speed as well, as the Stribeck part does.
    """

    name = "dwell_time"
    law = "ageing"
    channel = "friction"
    equation = r"C_0 \to C_0 + A a, \quad \dot a = (1 - a)/T - a |v|/D"
    symptom = "a friction level that is higher after a rest, whatever the speed, and falls with the distance slid"
    shows = "start"
    source = "Dieterich (1979); Ruina (1983)"
    kin = ("rest",)
    elusive = True
    parameters = (
        Parameter("rise", "N m", "rise of the level after a long rest", 0.0, 0.0),
        Parameter("time", "s", "time over which it rises", 1.0, 0.1, 1e3, log=True),
        Parameter("distance", "rad", "slide that renews the contact", 0.05, 1e-4, 10.0, log=True, firm=True),
        Parameter("start", "1", "age at which a recording starts, of that after a long rest", 0.0, 0.0, OLDEST),
    )
    states = ("age",)

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        size = 0.5 * max(scale.friction, 0.02 * scale.torque)
        distances = (min(max(part * scale.travel, 2e-3), 0.5 * scale.renews) for part in (0.01, 0.05))
        return tuple({"rise": size, "time": 0.7, "distance": distance, "start": 0.5} for distance in distances)

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        # a high one that any slide renews at once is friction that falls as 1 / v
        risen = -values["rise"] * math.expm1(-1.0 / values["time"])  # in a second
        return risen < scale.rises and values["distance"] < scale.renews

    def constants(self, constants: Parameters, s: Signals, x: States, p: Parameters) -> Parameters:
        return {**constants, "C0": constants["C0"] + p["rise"] * x["age"]}

    def derivatives(self, s: Signals, x: States, p: Parameters) -> dict[str, Expression]:
        a = x["age"]
        return {"age": (1.0 - a) / p["time"] - s.slide * a / p["distance"]}

    def initial(self, s: Signals, p: Parameters) -> dict[str, Expression]:
        return {"age": ca.if_else(s.lead > 0.0, 0.0, p["start"])}
