"""Elastic micro-motion before sliding, as a row of elements that give way one after the other."""

from __future__ import annotations

import math
from itertools import pairwise
from types import MappingProxyType
from typing import final

import casadi as ca

from stribeck.model.bristles import Bristle, at_least
from stribeck.model.values import Expression, Parameters, Signals, States

EDGES = (0.0, 0.5, 1.6, math.inf)  # of level / stiffness: classes of the distance at which elements give way
LAST = 0.05  # of an element's limit: over so much its torque bends into it, so that derivatives stay finite


def _shares() -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return each class's share of the stiffness and of the level.

    With distances spread exponentially the elements together follow Dahl's curve from rest, G (1 - exp(-sigma_0 x/G)).
    """
    beyond = [(math.exp(-u), (1.0 + u) * math.exp(-u)) if math.isfinite(u) else (0.0, 0.0) for u in EDGES]
    pairs = list(pairwise(beyond))
    return tuple(a[0] - b[0] for a, b in pairs), tuple(a[1] - b[1] for a, b in pairs)


STIFFNESS, LEVEL = _shares()
NAMES = tuple(f"element_{i + 1}" for i in range(len(LEVEL)))


@final
class PreslidingMaxwellSlip(Bristle):
    """Springs in parallel, each with a slider of its own, in place of the sign function: inner loops close.

    A single bristle drifts under small back-and-forth loads and is twice as stiff after a reversal as at rest; a row of
    elements keeps the contact's own stiffness sigma_0 in both.
    """

    name = "presliding"
    law = "maxwell_slip"
    channel = "friction"
    equation = (
        r"\dot b_i = \kappa_i \sigma_0 v \ [\,|b_i| < \lambda_i G\,], \quad "
        r"\tau_f = \sum_i (b_i + \kappa_i \sigma_1 v \ [\,|b_i| < \lambda_i G\,]) + C_2 v"
    )
    symptom = "a residual at velocity reversals that grows with the distance moved since, in loops that close"
    shows = "travel"
    source = "Iwan (1966); generalized Maxwell-slip: Al-Bender, Lampaert & Swevers (2005)"
    kin = ("rest",)
    abrupt = True
    states = NAMES
    state_units = MappingProxyType(dict.fromkeys(NAMES, "N m"))

    def bristle_holding(self, torque: Expression, level: Expression) -> dict[str, Expression]:
        size, at, given, stiff = ca.fabs(torque) / at_least(level), 0.0, 0.0, 1.0
        way: Expression = 0.0
        for stiffness, limit in zip(STIFFNESS, LEVEL, strict=True):  # each gives way before the next one does
            ends = limit / stiffness
            way = way + ca.fmin(ca.fmax(size - given, 0.0), stiff * (ends - at)) / stiff
            given, at, stiff = given + stiff * (ends - at), ends, stiff - stiffness
        parts = zip(NAMES, STIFFNESS, LEVEL, strict=True)
        return {name: ca.sign(torque) * at_least(level) * ca.fmin(k * way, limit) for name, k, limit in parts}

    def bristle_shares(self) -> tuple[float, ...]:
        return LEVEL  # of elements that hold nothing, none is beyond its limit before all are

    def bristle_torque(self, level: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        sticking = [_sticking(level, i, s, x) for i in range(len(NAMES))]
        held = sum(share * part for share, part in zip(STIFFNESS, sticking, strict=True))
        return sum(x[name] for name in NAMES) + p["damping"] * s.velocity * held

    def bristle_derivatives(self, level: Expression, s: Signals, x: States, p: Parameters) -> dict[str, Expression]:
        return {
            name: STIFFNESS[i] * p["stiffness"] * s.velocity * _sticking(level, i, s, x) for i, name in enumerate(NAMES)
        }

    def bristle_moved(self, level: Expression, distance: Expression, x: States, p: Parameters) -> dict[str, Expression]:
        limits = [share * at_least(level) for share in LEVEL]
        moved = [x[name] + share * p["stiffness"] * distance for name, share in zip(NAMES, STIFFNESS, strict=True)]
        return {name: _slid(b, limit, distance) for name, b, limit in zip(NAMES, moved, limits, strict=True)}


def _slid(torque: Expression, limit: Expression, distance: Expression) -> Expression:
    """Return an element's torque once it has given way ahead; turned back it unloads, whatever its limit is there."""
    backward = ca.if_else(distance < 0.0, ca.fmax(torque, -limit), torque)
    return ca.if_else(distance > 0.0, ca.fmin(torque, limit), backward)


def _sticking(level: Expression, i: int, s: Signals, x: States) -> Expression:
    """Return 1 where an element's torque is off its limit or leaves it, 0 at it, negative beyond (a falling level)."""
    limit = LEVEL[i] * at_least(level)
    ahead = x[NAMES[i]] * ca.sign(s.velocity) / limit
    return ca.fmin(1.0, (1.0 - ahead) / LAST)
