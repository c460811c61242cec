"""A contact that ages at rest alone, and is worn off by the way that it slides."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import final

import casadi as ca

from stribeck.model.effect import FrictionEffect
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States

STILL = 1e-3  # rad/s (m/s on an axis in m), up to which a joint rests
OLDEST = 2.0  # an arm may have rested since the day before


@final
class DwellTimeAtRest(FrictionEffect):
    """The level rises with the time at rest, and what it has risen by is gone with the distance slid, however slowly.

    The ageing law has a contact age in slow motion as well, so that slow friction stays raised; here it is as it was.
    """

    name = "dwell_time"
    law = "at_rest"
    channel = "friction"
    equation = r"C_0 \to C_0 + A a, \quad \dot a = (1 - a)/T \text{ at rest}, \quad \dot a = -a |v|/D \text{ in motion}"
    symptom = (
        "a friction level that is higher after a rest, the more the longer it was, and falls with the distance slid"
    )
    shows = "start"
    source = "Kato, Sato & Matsubayashi (1972) for the growth; Rabinowicz (1958) for the slide that ends it"
    kin = ("rest",)
    elusive = True
    parameters = (
        Parameter("rise", "N m", "rise of the level after a long rest", 0.0, 0.0),
        Parameter("time", "s", "time over which it rises", 1.0, 0.05, 1e3, log=True),
        Parameter("distance", "rad", "slide that wears it off", 0.05, 1e-4, 10.0, log=True, firm=True),
        Parameter("start", "1", "age at which a recording starts, of that after a long rest", 0.0, 0.0, OLDEST),
    )
    states = ("age",)

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        size = 0.5 * max(scale.friction, 0.02 * scale.torque)
        distances = (min(max(part * scale.travel, 2e-3), 0.5 * scale.renews) for part in (0.01, 0.05))
        return tuple({"rise": size, "time": 0.5, "distance": distance, "start": 0.5} for distance in distances)

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        # a high one that any slide renews at once fits what noise and filters do around rest
        risen = -values["rise"] * math.expm1(-1.0 / values["time"])  # in a second
        return risen < scale.rises and values["distance"] < scale.renews

    def constants(self, constants: Parameters, s: Signals, x: States, p: Parameters) -> Parameters:
        return {**constants, "C0": constants["C0"] + p["rise"] * x["age"]}

    def derivatives(self, s: Signals, x: States, p: Parameters) -> dict[str, Expression]:
        still, a = 1.0 / (1.0 + (s.slide / STILL) ** 4), x["age"]
        return {"age": still * (1.0 - a) / p["time"] - (1.0 - still) * s.slide * a / p["distance"]}

    def initial(self, s: Signals, p: Parameters) -> dict[str, Expression]:
        return {"age": ca.if_else(s.lead > 0.0, 0.0, p["start"])}
