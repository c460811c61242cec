"""Elastic micro-motion before sliding, as a bristle that does not creep below its break-away."""

from __future__ import annotations

import math
from types import MappingProxyType
from typing import final

import casadi as ca

from stribeck.model.bristles import Bristle, at_least
from stribeck.model.values import Expression, Parameters, Signals, States

ELASTIC = 0.7  # of the level, up to which nothing slides: z_ba / z_ss of the paper's example
KNEE = 1.0 - ELASTIC
PARTS = 2  # of a way beyond break-away, each by the midpoint rule: within 0.004 of the level however long it is
TINY = 1e-9


@final
class PreslidingElastoPlastic(Bristle):
    """A bristle that is a spring up to 0.7 of the friction level, and gives way from there on.

    The plain bristle creeps under any torque and rounds every reversal: this one holds still and unloads along its
    spring. The state is the bristle's torque b = sigma_0 z.
    """

    name = "presliding"
    law = "elasto_plastic"
    channel = "friction"
    equation = (
        r"\dot b = \sigma_0 (v - a\,|v| b / G(v)), \quad a = \sin^2 \frac{\pi c}{2}, \quad "
        r"c = \frac{b\,\mathrm{sgn}(v) / G(v) - 0.7}{0.3}\ [0 \leq c \leq 1], \quad "
        r"\tau_f = b + \sigma_1 \dot b / \sigma_0 + C_2 v"
    )
    symptom = "a residual at velocity reversals that grows in proportion to the distance moved since, up to a knee"
    shows = "travel"
    source = "elasto-plastic: Dupont, Hayward, Armstrong & Altpeter (2002)"
    kin = ("rest",)
    states = ("torque",)
    state_units = MappingProxyType({"torque": "N m"})

    def bristle_torque(self, level: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        return x["torque"] + p["damping"] * s.velocity * _held(level, s, x)

    def bristle_derivatives(self, level: Expression, s: Signals, x: States, p: Parameters) -> dict[str, Expression]:
        return {"torque": p["stiffness"] * s.velocity * _held(level, s, x)}

    def bristle_moved(self, level: Expression, distance: Expression, x: States, p: Parameters) -> dict[str, Expression]:
        limit, way = at_least(level), ca.sign(distance)
        loaded, pulled = way * x["torque"] / limit, way * p["stiffness"] * distance / limit
        beyond = ca.fmax(pulled - ca.fmax(ELASTIC - loaded, 0.0), 0.0) / PARTS
        bent = ca.fmax(loaded, ELASTIC)
        for _ in range(PARTS):
            middle = 1.0 - (1.0 - bent) * ca.exp(-0.5 * beyond * _rate(bent))
            bent = 1.0 - (1.0 - bent) * ca.exp(-beyond * _rate(middle))
        return {"torque": ca.if_else(way == 0.0, x["torque"], way * limit * ca.fmin(loaded + pulled, bent))}


def _held(level: Expression, s: Signals, x: States) -> Expression:
    """Return the share of a motion that the bristle takes up: 1 up to break-away, 0 at the level, negative beyond."""
    loaded = x["torque"] * ca.sign(s.velocity) / at_least(level)
    return ca.if_else(loaded < ELASTIC, 1.0, (1.0 - loaded) * _rate(loaded))


def _rate(loaded: Expression) -> Expression:
    """Return that share over what is left up to the level, from break-away on."""
    left = ca.fmin(ca.fmax((1.0 - loaded) / KNEE, TINY), 1.0)
    return 1.0 + ca.fmin(loaded, 1.0) * ca.sin(0.5 * math.pi * left) ** 2 / (KNEE * left)
