"""A rubber stop that the arm runs into, or a cable that comes taut."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import final

import casadi as ca

from stribeck.model.effect import ExternalEffect
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States
from stribeck.model.walls import likeliest_walls
from stribeck.model.waves import Trace


@final
class ContactLinear(ExternalEffect):
    """A one-sided spring on the joint's link, beyond the position where the stiffness is positive, else before it."""

    name = "contact"
    law = "linear"
    channel = "external"
    equation = r"\tau = k \delta, \quad \delta = \max(\mathrm{sign}(k)(q - q_w), 0)"
    symptom = "a residual beyond one position, nothing before it, that pushes back in proportion to the depth"
    shows = "position"
    source = "Hooke's law, on one side"
    kin = ("curve",)
    parameters = (
        Parameter("stiffness", "N m/rad", "stiffness, negative for a stop on the negative side"),
        Parameter("position", "rad", "where the stop begins", reach=20.0),
    )

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        size, place = scale.torque / (0.1 * scale.travel), 0.3 * scale.travel
        return tuple({"stiffness": side * size, "position": scale.middle + side * place} for side in (1.0, -1.0))

    def starts_from(self, scale: Scale, trace: Trace) -> tuple[dict[str, float], ...]:
        least = 0.02 * scale.torque / scale.travel
        walls = zip((1.0, -1.0), likeliest_walls(trace, 1.0), strict=True)
        return tuple({"stiffness": side * max(side * k, least), "position": place} for side, (k, place) in walls)

    def also(self, values: Mapping[str, float], scale: Scale) -> tuple[str, ...]:
        # what is leaned on for most of the time is hardly a stop: a cable that hangs slack on one side
        leaned = math.copysign(1.0, values["stiffness"]) * (scale.middle - values["position"]) > 0.0
        return ("cable_spring",) if leaned else ()

    def torque(self, s: Signals, x: States, p: Parameters) -> Expression:
        side = ca.sign(p["stiffness"])
        return p["stiffness"] * ca.fmax(side * (s.link_position - p["position"]), 0.0)
