"""A break-away torque that grows with the time at rest, and is kept until the next rest."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import final

import casadi as ca

from stribeck.model.effect import FrictionEffect
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States

STILL = 1e-3  # rad/s (m/s on an axis in m), up to which a joint rests
SETTLES = 0.01  # s, within which a rest is known for one, and forgotten


@final
class DwellTimeFrozen(FrictionEffect):
    """The rise that a rest has left stays as it is while the joint slides, however far; the next rest starts anew.

    So the seven-parameter model has it. Like the Stribeck part it falls off with the speed: what is left of it shows
    again where the joint slows down.
    """

    name = "dwell_time"
    law = "frozen"
    channel = "friction"
    equation = r"C_1 \to C_1 + A\,t_s / (t_s + T), \quad t_s\ \mathrm{the\ last\ rest}"
    symptom = "a break-away torque that grows with the rest before it; slow motion stays harder until the next rest"
    shows = "start"
    source = "Armstrong-Helouvry, Dupont & Canudas de Wit (1994), seven-parameter model"
    kin = ("rest",)
    elusive = True
    parameters = (
        Parameter("rise", "N m", "rise of the break-away torque after a long rest", 0.0, 0.0),
        Parameter("time", "s", "rest after which half of it is there", 0.5, 0.02, 1e3, log=True),
        Parameter("start", "s", "rest before a recording", 0.0, 0.0, 1e5),
    )
    states = ("rest", "grown")
    state_units = MappingProxyType({"rest": "s", "grown": "1"})

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return ({"rise": 0.5 * max(scale.friction, 0.02 * scale.torque), "time": 0.5, "start": 0.5},)

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        # a higher one fits what noise and filters do around rest, as long as rests are short enough
        return values["rise"] / (1.0 + values["time"]) < scale.rises

    def constants(self, constants: Parameters, s: Signals, x: States, p: Parameters) -> Parameters:
        return {**constants, "C1": constants["C1"] + p["rise"] * x["grown"]}

    def derivatives(self, s: Signals, x: States, p: Parameters) -> dict[str, Expression]:
        still = 1.0 / (1.0 + (s.slide / STILL) ** 4)
        reached = x["rest"] / (x["rest"] + p["time"])
        return {
            "rest": still - (1.0 - still) * x["rest"] / SETTLES,
            "grown": still * (reached - x["grown"]) / SETTLES,
        }

    def initial(self, s: Signals, p: Parameters) -> dict[str, Expression]:
        rest = ca.if_else(s.lead > 0.0, 0.0, p["start"])
        return {"rest": rest, "grown": rest / (rest + p["time"])}
