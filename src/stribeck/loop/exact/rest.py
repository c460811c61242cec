"""Whether a loop that hardly moves is at rest, creeps to rest, or will come back: decided by its linear flow.

Near critical damping a joint comes back after a time that grows without bound, at a speed below any tolerance; a
threshold on the speed would call that rest. What is left of the way is linear, so its eigenvalues decide.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm
from scipy.optimize import brentq

from stribeck.loop.exact.place import FILTER, INTEGRAL, LAG, THETA, Place, Stretch
from stribeck.loop.exact.rounds import NONE, Rounds
from stribeck.simulate.source import CONTROLLER_STATES

Floats = NDArray[np.float64]
_LONGEST = 60.0  # time constants of the slowest mode within which it comes back, if it does
_GRID = 600
_SAMPLES = 64
_FEW, _CALM = 8, 1e-5  # samples, and rad/s that a joint at rest does not reach in them
_MOST_HOPS = 10  # over quiet stretches, without a turn
_MEMORY_OF_INTEGRAL = 2
_SAME_ERROR = 1e-6  # rad: so little an error that lasts may change in as long again
_AWAY = 1000.0  # s in which an unstable place is left


@dataclass(frozen=True)
class Rest:
    """Where a quiet loop ends: ``settled`` where it is, or at ``place``, or leaving by itself."""

    settled: bool
    place: Place | None = None


def active_states(rounds: Rounds) -> list[int]:
    """Return the indices of the states that act on a continuous loop's motion; an unused integral does not."""
    layout, chosen = rounds.layout, []
    for entry in rounds.loop.joints:
        j = rounds.index(entry.joint)
        chosen += [j, layout.n + j]
        wanted = {INTEGRAL: entry.ki > 0, FILTER: entry.velocity_filter > 0, LAG: entry.actuator_lag > 0}
        chosen += [layout.own(j, which) for which, used in wanted.items() if used]
        if entry.compensation.kind == "adaptive":
            chosen += [layout.own(j, THETA + i) for i in range(3)]
    return sorted(chosen + list(range(2 * layout.n, layout.size)))


def states_of(rounds: Rounds, joints: Collection[int]) -> set[int]:
    """Return the indices of the states of some joints and of their continuous controllers."""
    layout = rounds.layout
    return {at for j in joints for at in (j, layout.n + j, *(layout.own(j, i) for i in range(CONTROLLER_STATES)))}


def deviations(rounds: Rounds, place: Place) -> Floats:
    """Return true position less reference (n,), rad; the position of a clamped joint."""
    return _less_reference(rounds, place, place.values[rounds.layout.state][: rounds.n].copy())


def seen_deviations(rounds: Rounds, place: Place) -> Floats:
    """Return measured position less reference (n,), rad; the position of a clamped joint."""
    state = place.values[rounds.layout.state][: rounds.layout.size]
    return _less_reference(rounds, place, rounds.engine.measured(state))


def _less_reference(rounds: Rounds, place: Place, q: Floats) -> Floats:
    for entry in rounds.loop.joints:
        j = rounds.index(entry.joint)
        q[j] -= entry.start + rounds.rate(j) * place.time
    return q


def winding(rounds: Rounds, place: Place, least: float) -> frozenset[int]:
    """Return the joints whose integral grows by an error over ``least`` (rad): if they stick, they break away some day.

    The error is the one that the controller sees, and none where a limit holds the integral.
    """
    with_integral = [rounds.index(entry.joint) for entry in rounds.loop.joints if entry.ki > 0.0]
    if not with_integral:
        return frozenset()
    if rounds.sampled:
        ts, memory = rounds.loop.sample_time, rounds.layout.memory
        after = rounds.run(place, NONE, duration=1.5 * ts, quiet=False).place
        grown = (after.values[memory] - place.values[memory]).reshape(rounds.n, -1)[:, _MEMORY_OF_INTEGRAL] / ts
        return frozenset(j for j in with_integral if abs(grown[j]) > least)
    rate, _ = rounds.slopes(place)
    return frozenset(j for j in with_integral if abs(rate[rounds.layout.own(j, INTEGRAL)]) > least)


def judge(rounds: Rounds, place: Place) -> Rest:
    """Say what becomes of a loop in which nothing moves relative to the references any more."""
    n = rounds.n
    modes, y = place.values[rounds.layout.modes], place.values[rounds.layout.state]
    sliding = [rounds.index(e.joint) for e in rounds.loop.joints if modes[rounds.index(e.joint)] != 0.0]
    if not sliding:
        return Rest(True)
    if rounds.sampled:
        return Rest(not _swings(rounds, place, sliding) and holds(rounds, place, sliding))
    stuck = {rounds.index(e.joint) for e in rounds.loop.joints} - set(sliding)
    kept = [i for i in active_states(rounds) if i not in stuck and i - n not in stuck]
    rate, slopes = rounds.slopes(place)
    for j in sliding:
        rate[j] -= rounds.rate(j)
    f, matrix = rate[kept], slopes[np.ix_(kept, kept)]
    roots = np.linalg.eigvals(matrix)
    lead = roots[np.argmax(roots.real)]
    back = [j for j in sliding if rounds.rate(j) == 0.0 and y[n + j] != 0.0]
    found = _first_return(matrix, f, [kept.index(j) for j in back], lead)
    if found is None:
        return Rest(bool(lead.real < 0.0))
    after, passed = found
    values = place.values.copy()
    moved = expm(_augmented(matrix, f) * after)[:-1, -1]
    for k, i in enumerate(kept):
        values[rounds.layout.state][i] += moved[k]
    for j in sliding:
        values[rounds.layout.state][j] += rounds.rate(j) * after
    values[rounds.layout.state][n + kept[passed]] = 0.0
    values[0], values[1] = values[0] + after, 1.0
    return Rest(False, replace(place, values=values))


def _swings(rounds: Rounds, place: Place, sliding: list[int]) -> bool:
    """Tell whether a sampled loop that dies away does so swinging, so that it comes back: by its last two modes."""
    velocity = rounds.run(place, NONE, rows=_SAMPLES, quiet=False).record[:, 1]
    for j in sliding:
        v = velocity[:, j] - rounds.rate(j)
        if rounds.rate(j) != 0.0 or not np.isfinite(v).all() or not v.any():
            continue
        a, b = np.linalg.lstsq(np.stack([v[8:-8], v[:-16]], axis=1), v[16:], rcond=None)[0]
        if a * a + 4.0 * b < 0.0:
            return True
    return False


def holds(rounds: Rounds, place: Place, joints: Collection[int]) -> bool:
    """Tell whether a sampled loop stays where it creeps to, once the velocity of some joints counts as none.

    The true velocity keeps its sign beyond any digit; else the law is at its rule for rest then.
    """
    moving = list(joints)
    if any(rounds.axes[j].true_velocity and rounds.axes[j].filter == 0.0 for j in moving):
        return True
    values, layout = place.values.copy(), rounds.layout
    state, memory = values[layout.state], values[layout.memory].reshape(rounds.n, -1)
    seen = rounds.engine.measured(state[: layout.size])
    for j in moving:
        state[rounds.n + j] = rounds.rate(j)
        memory[j, 0] = seen[j] - rounds.rate(j) * rounds.loop.sample_time
        memory[j, 1] = rounds.rate(j)
        if rounds.rate(j) == 0.0:
            values[layout.modes][j] = 0.0
    record = rounds.run(replace(place, values=values), NONE, rows=rounds.history + _FEW, quiet=False).record
    drift = np.abs(record[:, 1, moving] - [rounds.rate(j) for j in moving])
    return bool(np.isfinite(drift).all() and drift.max() < _CALM)


def _augmented(matrix: Floats, f: Floats) -> Floats:
    size = len(f)
    whole = np.zeros((size + 1, size + 1))
    whole[:size, :size], whole[:size, size] = matrix, f
    return whole


def _first_return(matrix: Floats, f: Floats, watched: list[int], lead: complex) -> tuple[float, int] | None:
    """Return when, and which of the ``watched`` positions' velocities first comes to zero; None where none does.

    The rate of change obeys the same linear equation, w' = M w, and has no digits to lose.
    """
    if not watched:
        return None
    longest = _LONGEST / max(abs(lead.real), 1e-9)
    if abs(lead.imag) > 1e-12:
        longest = 2.2 * np.pi / abs(lead.imag)
    step = longest / _GRID
    stride, now = expm(matrix * step), f
    for k in range(_GRID):
        after = stride @ now
        for i in watched:
            if after[i] * f[i] < 0.0:
                begin = now.copy()
                part = brentq(lambda t, i=i, begin=begin: (expm(matrix * t) @ begin)[i] / abs(f[i]), 0.0, step)
                return float(k * step + part), i
        now = after
    return None


def ahead(rounds: Rounds, place: Place) -> float:
    """Return for how long (s) to follow a loop before what it does along a ramp counts; 0 where it may now.

    What resists the joint may be met later: it is followed for the loop's own duration.
    """
    return max(rounds.given.duration - place.time, 0.0) if rounds.passes else 0.0


def _unsure(rounds: Rounds, place: Place, stood: Place | None) -> float:
    """Return for how long (s) to follow a quiet loop on along its ramp; ``stood`` is where it was quiet before."""
    if not rounds.passes:
        return 0.0
    if (way := ahead(rounds, place)) > 0.0:
        return way
    return 0.0 if stood is not None and _same(rounds, place, stood) else max(place.time, 1.0)


def _same(rounds: Rounds, place: Place, other: Place) -> bool:
    return bool(np.abs(deviations(rounds, place) - deviations(rounds, other)).max() < _SAME_ERROR)


def follow(rounds: Rounds, place: Place, watch: int, most: int, duration: float = 1e9) -> Stretch:
    """Run as `Rounds.run` does, and on where a quiet loop is not at rest; ``quiet`` then means rest.

    A loop that goes on and on too slowly to be seen, without ever turning, creeps to rest. Where a ramp leads past
    places that differ, an error that stands still after the loop's duration may do so for a moment alone: it is to stay
    for as long again.

    Parameters
    ----------
    rounds : Rounds
    place : Place
        From where.
    watch, most : int
        As of `Rounds.run`: the joint whose turns are counted, and how many.
    duration : float
        Longest time, s.
    """
    turns: list[np.ndarray] = []
    stood: Place | None = None
    arrives = False  # at the end of the loop's duration
    quiet, end, hops, longest = True, place.time + duration, 0, _AWAY
    while True:
        left = end - place.time
        done = rounds.run(place, watch, most=most, duration=left if quiet else min(left, longest), quiet=quiet)
        turns.append(done.turns)
        most -= len(done.turns) if watch < 0 else int(np.sum(done.turns["joint"] == watch))
        hops = 0 if len(done.turns) else hops + 1
        place, goes_on = done.place, not quiet and done.why == "end" and place.time < end
        if arrives:
            stood = place
        elif stood is not None and not _same(rounds, place, stood):
            stood = None
        quiet, longest, arrives = True, _AWAY, False
        if done.why == "quiet" and (way := _unsure(rounds, place, stood)) > 0.0:
            quiet, goes_on, longest, stood, arrives = False, True, way, place, ahead(rounds, place) > 0.0
        elif done.why == "quiet" and hops <= _MOST_HOPS:
            ending = judge(rounds, place)
            if not ending.settled:
                place, quiet, goes_on = ending.place or place, ending.place is not None, True
        if goes_on and most > 0 and place.time < end:
            continue
        why = "enough" if most <= 0 else done.why
        return Stretch(why, np.concatenate(turns), place, done.record)
