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

DAMPED = 0.02  # of what the spring would push with at full travel, that the damper does at usual speed, at first
LIFELESS = 0.3  # the same, from which it is a damper, and no stop


@final
class ContactLinear(ExternalEffect):
    """A one-sided spring and damper on the joint's link, beyond the position, or before it: by the sign of stiffness.

    It pushes and never pulls: the link leaves it before it has recovered.
    """

    name = "contact"
    law = "linear"
    channel = "external"
    equation = (
        r"\tau = \mathrm{sign}(k) \max(|k| \delta + d \dot\delta, 0) \;\text{where}\; \delta > 0, \quad "
        r"\delta = \max(\mathrm{sign}(k)(q - q_w), 0)"
    )
    symptom = "a residual beyond one position, nothing before it, that pushes back in proportion to the depth"
    shows = "position"
    source = "Hooke's law and a damper beside it (Kelvin & Voigt), on one side"
    kin = ("curve",)
    edged = True
    parameters = (
        Parameter("stiffness", "N m/rad", "stiffness, negative for a stop on the negative side"),
        Parameter("position", "rad", "where the stop begins", reach=20.0),
        Parameter("damping", "N m s/rad", "damping beyond it", 0.0, 0.0),
    )

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        size, place = scale.torque / (0.1 * scale.travel), 0.3 * scale.travel
        damping = DAMPED * size * scale.travel / scale.speed
        return tuple(
            {"stiffness": side * size, "position": scale.middle + side * place, "damping": damping}
            for side in (1.0, -1.0)
        )

    def starts_from(self, scale: Scale, trace: Trace) -> tuple[dict[str, float], ...]:
        least = 0.02 * scale.torque / scale.travel
        walls = zip((1.0, -1.0), likeliest_walls(trace, 1.0), strict=True)
        return tuple(
            {"stiffness": side * max(side * k, least), "position": place, "damping": 0.0} for side, (k, place) in walls
        )

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        return values["damping"] * scale.speed < LIFELESS * abs(values["stiffness"]) * scale.travel

    def also(self, values: Mapping[str, float], scale: Scale) -> tuple[str, ...]:
        # what is leaned on for most of the time is hardly a stop: a cable that hangs slack on one side
        leaned = math.copysign(1.0, values["stiffness"]) * (scale.middle - values["position"]) > 0.0
        return ("cable_spring",) if leaned else ()

    def torque(self, s: Signals, x: States, p: Parameters) -> Expression:
        side = ca.sign(p["stiffness"])
        depth = side * (s.link_position - p["position"])
        push = side * p["stiffness"] * depth + p["damping"] * side * s.link_velocity
        return side * ca.if_else(depth > 0.0, ca.fmax(push, 0.0), 0.0)
