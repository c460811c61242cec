"""A wall that the arm runs into."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import final

import casadi as ca
import numpy as np

from stribeck.model.effect import ExternalEffect
from stribeck.model.values import Expression, Parameter, Parameters, Scale, Signals, States
from stribeck.model.waves import Trace

SHARES = (0.5, 0.65, 0.75, 0.85, 0.92, 0.97)  # of the samples: where a wall may begin


@final
class Contact(ExternalEffect):
    """A soft stop on the joint's link. The sign of the stiffness tells the side: positive beyond the position."""

    name = "contact"
    channel = "external"
    equation = r"\tau = k \delta^{3/2} (1 + c \dot\delta), \quad \delta = \max(\mathrm{sign}(k)(q - q_w), 0)"
    symptom = "a residual beyond one position, nothing before it, that pushes back and grows with the depth"
    shows = "position"
    source = "Hunt & Crossley (1975)"
    kin = ("curve",)
    parameters = (
        Parameter("stiffness", "N m/rad^1.5", "stiffness, negative for a wall on the negative side"),
        Parameter("position", "rad", "where the wall begins", 0.0, -20.0, 20.0),
        Parameter("damping", "s/rad", "damping over stiffness", 0.0, 0.0, 20.0),
    )

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        size, place = scale.torque / (0.1 * scale.travel) ** 1.5, 0.3 * scale.travel
        return tuple({"stiffness": side * size, "position": side * place, "damping": 0.2} for side in (1.0, -1.0))

    def starts_from(self, scale: Scale, trace: Trace) -> tuple[dict[str, float], ...]:
        tried = []
        for side in (1.0, -1.0):
            places = [float(np.quantile(side * trace.position, share)) for share in SHARES]
            tried += [(*_stiffness(side * trace.position - place, side, trace), side, place) for place in places]
        _, size, side, place = max(tried)
        least = 0.02 * scale.torque / scale.travel**1.5
        return ({"stiffness": side * max(size, least), "position": side * place, "damping": 0.2},)

    def also(self, values: Mapping[str, float], scale: Scale) -> tuple[str, ...]:
        # what is leaned on for most of the time is hardly a stop: a cable that hangs slack on one side, or stiffens
        leaned = math.copysign(1.0, values["stiffness"]) * (scale.middle - values["position"]) > 0.0
        return ("cable_spring",) if leaned else ()

    def torque(self, s: Signals, x: States, p: Parameters) -> Expression:
        side = ca.sign(p["stiffness"])
        depth = ca.fmax(side * (s.link_position - p["position"]), 0.0)
        push = ca.fmax(1.0 + p["damping"] * side * s.link_velocity, 0.0)
        return p["stiffness"] * depth**1.5 * push


def _stiffness(beyond: np.ndarray, side: float, trace: Trace) -> tuple[float, float]:
    """Return the squares that a wall saves, and its stiffness; what a line and dry friction take is not a wall's."""
    depth = np.maximum(beyond, 0.0) ** 1.5
    others = np.stack([np.ones_like(depth), beyond, np.sign(trace.velocity)], axis=1)
    wall, left = (v - others @ np.linalg.lstsq(others, v, rcond=None)[0] for v in (depth, side * trace.residual))
    size = float(wall @ left) / max(float(wall @ wall), 1e-300)
    return float(wall @ left) * abs(size), size
