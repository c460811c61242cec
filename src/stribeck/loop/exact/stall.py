"""Joints that stand still for good though ever more is asked of them: the drive cannot give what would move them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from stribeck.arm import unit_at
from stribeck.loop.exact.place import Place
from stribeck.loop.exact.rest import winding
from stribeck.loop.exact.rounds import NONE, Rounds
from stribeck.loop.exact.turns import TINY

Floats = NDArray[np.float64]
_LONG = {"continuous": 1e3, "sampled": 100.0}  # s over which nothing may change
_SAME = 1e-9  # of the torque


def stalled(rounds: Rounds, place: Place) -> Mapping[int, str]:
    """Return the joints that the drive cannot move, with the reason in words.

    Such a joint stands still under a torque that stays the same, though its error or its integral grows.
    """
    asked = [j for j in _asked(rounds, place) if abs(_velocity(rounds, place)[j]) < TINY]
    if not asked:
        return {}
    duration = _LONG["sampled" if rounds.sampled else "continuous"]
    after = rounds.run(place, NONE, duration=duration, quiet=False).place
    moved = np.abs(_position(rounds, after) - _position(rounds, place))
    before, torque = _applied(rounds, place), _applied(rounds, after)
    same = (np.abs(torque - before) <= _SAME * np.abs(torque)) & (torque != 0.0)
    return {j: _told(rounds, j, float(torque[j])) for j in asked if same[j] and moved[j] < TINY}


def _asked(rounds: Rounds, place: Place) -> list[int]:
    """Return the joints of which ever more is asked where they stand still."""
    moves = {j for entry in rounds.loop.joints for j in [rounds.index(entry.joint)] if rounds.rate(j) != 0.0}
    return sorted(moves | winding(rounds, place, TINY))


def _told(rounds: Rounds, j: int, torque: float) -> str:
    unit = unit_at("N m", rounds.arm.joints[j].kind)
    return f"the drive cannot move it: it gives {abs(torque):.4g} {unit} and no more"


def _position(rounds: Rounds, place: Place) -> Floats:
    return place.values[rounds.layout.state][: rounds.n]


def _velocity(rounds: Rounds, place: Place) -> Floats:
    return place.values[rounds.layout.state][rounds.n : 2 * rounds.n]


def _applied(rounds: Rounds, place: Place) -> Floats:
    """Return the torque (n,) that reaches each joint, N m."""
    layout, values = rounds.layout, place.values
    state, modes, command = values[layout.state][: layout.size], values[layout.modes], values[layout.torque]
    given = rounds.engine.forward.outputs(place.time, state, modes, command, rounds.p)
    return np.asarray(given[3].full().ravel(), dtype=float)
