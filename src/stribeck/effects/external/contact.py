"""A wall that the arm runs into."""

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

EXPONENT = 1.5  # of a ball on a plane
DAMPING = 0.2  # s/rad, at first
# damping times speed of approach, at which nothing bounces back (Hunt & Crossley 1975): beyond, it is a damper's force
LIFELESS = 1.5


@final
class Contact(ExternalEffect):
    """A soft stop on the joint's link. The sign of the stiffness tells the side: positive beyond the position."""

    name = "contact"
    law = "hunt_crossley"
    channel = "external"
    equation = r"\tau = k \delta^{3/2} (1 + c \dot\delta), \quad \delta = \max(\mathrm{sign}(k)(q - q_w), 0)"
    symptom = "a residual beyond one position, nothing before it, that pushes back and grows with the depth"
    shows = "position"
    source = "Hunt & Crossley (1975)"
    kin = ("curve",)
    edged = True
    parameters = (
        Parameter("stiffness", "N m/rad^1.5", "stiffness, negative for a wall on the negative side"),
        Parameter("position", "rad", "where the wall begins", reach=20.0),
        Parameter("damping", "s/rad", "damping over stiffness", 0.0, 0.0, 20.0),
    )

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        size, place = scale.torque / (0.1 * scale.travel) ** EXPONENT, 0.3 * scale.travel
        return tuple(
            {"stiffness": side * size, "position": scale.middle + side * place, "damping": _damping(scale)}
            for side in (1.0, -1.0)
        )

    def starts_from(self, scale: Scale, trace: Trace) -> tuple[dict[str, float], ...]:
        least = 0.02 * scale.torque / scale.travel**EXPONENT
        walls = zip((1.0, -1.0), likeliest_walls(trace, EXPONENT), strict=True)
        return tuple(
            {"stiffness": side * max(side * k, least), "position": place, "damping": _damping(scale)}
            for side, (k, place) in walls
        )

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        return values["damping"] * scale.speed < LIFELESS

    def also(self, values: Mapping[str, float], scale: Scale) -> tuple[str, ...]:
        # what is leaned on for most of the time is hardly a stop: a cable that hangs slack on one side, or stiffens
        leaned = math.copysign(1.0, values["stiffness"]) * (scale.middle - values["position"]) > 0.0
        return ("cable_spring",) if leaned else ()

    def torque(self, s: Signals, x: States, p: Parameters) -> Expression:
        side = ca.sign(p["stiffness"])
        depth = ca.fmax(side * (s.link_position - p["position"]), 0.0)
        push = ca.fmax(1.0 + p["damping"] * side * s.link_velocity, 0.0)
        return p["stiffness"] * depth**EXPONENT * push


def _damping(scale: Scale) -> float:
    return min(DAMPING, 0.5 * LIFELESS / scale.speed)
