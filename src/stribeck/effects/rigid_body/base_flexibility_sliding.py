"""A base that slides to and fro, or tilts about a foot beside the first axis."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, final

import casadi as ca

from stribeck.model.effect import StandEffect
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States
from stribeck.model.waves import Trace, ringing

SMALL = 1e-4  # m, a typical size of what it is off at first
DAMPED = 0.2  # of critical, as a stand on rubber may be
LIGHTEST = 0.3  # of the mass that the first joint swings about its axis, taken to be at its link's length
WAYS = (0.0, 0.25 * math.pi, 0.5 * math.pi, 0.75 * math.pi)


@final
class BaseFlexibilitySliding(StandEffect):
    """The stand gives way along a straight line, on a spring and damper, under the force of the arm's links.

    It carries the first axis along, so that all joints feel its acceleration as they feel gravity. What tilts about its
    foot turns by as much as it moves, over the foot's distance: the arm's torque tilts it as well. It starts where it
    rests under the arm's weight, or off that, by as much in each recording.
    """

    name = "base_flexibility"
    law = "sliding"
    channel = "rigid_body"
    equation = (
        r"m_b \ddot s + d \dot s + k s = -n \cdot f - c\,\tau_1, "
        r"\quad g \to g - n \ddot s, \quad q_1 \to q_1 + c\,s, \quad s(0) = s_0"
    )
    symptom = "a slow, lightly damped resonance at all joints, each as its pose lets it feel the base's acceleration"
    shows = "frequency"
    source = "Lew & Moon (2001), manipulators on a compliant base"
    filters = True
    nonlinear = True
    whole_arm = True
    alone = "a mass that swings on the link (a soft tool or load)"
    parameters = (
        Parameter("stiffness", "N/m", "stiffness of the stand", math.inf, 1e-6, 1e11, log=True),
        Parameter("damping", "N s/m", "damping of the stand", 0.0, 1e-9, 1e8, log=True),
        Parameter("mass", "kg", "mass of what slides with the base, the arm apart", 1.0, 1e-6, 1e6, log=True),
        Parameter("direction", "rad", "along which it slides, from the base frame's x", 0.0, -10.0, 10.0),
        Parameter("turn", "rad/m", "by how much it turns as it moves, as what tilts about its foot", 0.0, -20.0, 20.0),
        Parameter("start", "m", "how far from its rest each recording starts", 0.0, -1.0, 1.0),
    )

    def sites(self, n: int) -> tuple[int, ...]:
        return (0,)

    def applies(self, arm: Any, joint: int) -> bool:
        return bool(arm.joints[0].kind == "revolute")  # along an axis that slides, it is the law that rocks

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        # a well damped start costs little at a wrong frequency, so that slow stands are reached from above
        slow = tuple(_start(scale, 1.0, way, 0.19) for way in WAYS[1::2])
        return (*slow, *(_start(scale, hertz, way) for hertz in (3.0, 8.0) for way in WAYS[::2]))

    def starts_from(self, scale: Scale, trace: Trace) -> tuple[dict[str, float], ...]:
        heard = ringing(trace, (0.8, 25.0))
        return (*self.starts(scale), *(_start(scale, hertz, way) for hertz in heard for way in WAYS))

    def initial(self, s: Signals, p: Parameters) -> dict[str, Expression]:
        leans = -p["turn"] * s.load / p["stiffness"]  # under the arm's weight, in the pose that it starts in
        return {"position": leans + ca.if_else(s.lead > 0.0, 0.0, p["start"]), "velocity": 0.0}  # not in midst of one

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        critical = 2.0 * math.sqrt(values["stiffness"] * (values["mass"] + _swung(scale)))
        return values["mass"] > LIGHTEST * _swung(scale) and values["damping"] < DAMPED * critical

    def way(self, p: Parameters) -> tuple[Expression, Expression]:
        return ca.cos(p["direction"]), ca.sin(p["direction"])

    def turn(self, p: Parameters) -> Expression:
        return p["turn"]

    def mass(self, p: Parameters) -> Expression:
        return p["mass"]

    def force(self, x: States, p: Parameters) -> Expression:
        return -p["stiffness"] * x["position"] - p["damping"] * x["velocity"]


def _swung(scale: Scale) -> float:
    """Return the inertia that the first joint moves as a mass at its link's end, kg."""
    return scale.inertia / (scale.length or 1.0) ** 2


def _start(scale: Scale, hertz: float, way: float, damped: float = 0.05) -> dict[str, float]:
    """Return the values of a stand as heavy as the arm that rings so fast along a direction, rad."""
    omega, whole = 6.2832 * hertz, 2.0 * _swung(scale)
    return {
        "stiffness": whole * omega**2, "damping": 2.0 * damped * whole * omega, "mass": 0.5 * whole, "direction": way,
        "turn": 0.0, "start": SMALL,
    }  # fmt: skip
