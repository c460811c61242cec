"""Joints that are left behind for good, though ever more is asked of them.

The drive of one cannot give what would move it, so that it stands still; another gives way to its ramp, but ever too
little, as against a spring.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from stribeck.arm import unit_at
from stribeck.loop.exact.place import Place
from stribeck.loop.exact.rest import deviations, winding
from stribeck.loop.exact.rounds import NONE, Rounds
from stribeck.loop.exact.turns import TINY

Floats = NDArray[np.float64]
_LONG = {"continuous": 1e3, "sampled": 100.0}  # s over which nothing may change
_SAME = 1e-9  # of the torque
PLACES = 3  # from which on a growing error is seen to grow steadily
_LEAST_GROWTH, _SAME_GROWTH, _NO_MOTION = 1e-4, 0.1, 1e-6  # of the ramp; of the growth before; of the ramp


def left_behind(rounds: Rounds, places: Sequence[Place], turns: np.ndarray, known: Mapping[int, str]) -> dict[int, str]:
    """Return the joints that are left behind, with the reason in words.

    Parameters
    ----------
    rounds : Rounds
    places : sequence of Place
        Where the loop was after each stretch so far.
    turns : structured array
        Of the last stretch.
    known : mapping
        Joints that are known to be.
    """
    others = {**stalled(rounds, places[-1], {*known, *turns["joint"].astype(int)}), **known}
    return {**_falling(rounds, places), **others}


def waiting(rounds: Rounds, place: Place) -> frozenset[int]:
    """Return the joints that stand still while ever more is asked of them, so that they may break away some day."""
    moves = {j for entry in rounds.loop.joints for j in [rounds.index(entry.joint)] if rounds.rate(j) != 0.0}
    asked = moves | winding(rounds, place, TINY)
    return frozenset(j for j in asked if abs(_velocity(rounds, place)[j]) < TINY)


def stalled(rounds: Rounds, place: Place, others: Collection[int] = ()) -> dict[int, str]:
    """Return the joints, ``others`` left out, that the drive cannot move, with the reason in words.

    Such a joint stands still under a torque that stays the same, though its error or its integral grows.
    """
    asked = sorted(waiting(rounds, place) - set(others))
    if not asked:
        return {}
    duration = _LONG["sampled" if rounds.sampled else "continuous"]
    done = rounds.run(place, NONE, duration=duration, quiet=False)
    if done.why != "end":  # nothing is known of what it could not be followed through
        return {}
    after = done.place
    moved = np.abs(_position(rounds, after) - _position(rounds, place))
    before, torque = _applied(rounds, place), _applied(rounds, after)
    same = (np.abs(torque - before) <= _SAME * np.abs(torque)) & (torque != 0.0)
    return {j: _told(rounds, j, float(torque[j])) for j in asked if same[j] and moved[j] < TINY}


def _falling(rounds: Rounds, places: Sequence[Place]) -> dict[int, str]:
    """Return the joints whose error grows along a ramp as steadily as the ramp, though they move.

    Only what stands around the arm does so for ever: gravity, or friction that depends on the position, comes round.
    """
    if len(places) < PLACES or not (rounds.passes and rounds.engine.meets):
        return {}
    time = np.array([place.time for place in places[-PLACES:]])
    growth = -np.diff([deviations(rounds, place) for place in places[-PLACES:]], axis=0) / np.diff(time)[:, None]
    found = {}
    for j in range(rounds.n):
        if (rate := rounds.rate(j)) == 0.0:
            continue
        before, now = growth[:, j] / rate  # 1: it does not move at all, and may only stick
        if _LEAST_GROWTH < now < 1.0 - _NO_MOTION and abs(now - before) < _SAME_GROWTH * now:
            unit = unit_at("rad/s", rounds.arm.joints[j].kind)
            found[j] = f"it falls ever further behind its ramp: its error grows by {now * abs(rate):.4g} {unit}"
    return found


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
