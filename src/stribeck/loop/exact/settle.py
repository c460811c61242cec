"""Settled cycles by simulation: on and on, in stretches that double, until two of them have the same averages."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from stribeck.arm import Arm
from stribeck.loop.cycle import STOPPED, Cycle
from stribeck.loop.exact.ending import Ending, all_die, answers, gather
from stribeck.loop.exact.engine import RoundsEngine
from stribeck.loop.exact.place import Place, Stretch
from stribeck.loop.exact.rest import ahead, follow, winding
from stribeck.loop.exact.rounds import ANY, NONE, Rounds
from stribeck.loop.exact.stall import left_behind, waiting
from stribeck.loop.exact.starts import starts
from stribeck.loop.exact.turns import CREEP, TINY, weighted, whole_rounds
from stribeck.simulate import Loop

Floats = NDArray[np.float64]
_FIRST, _LONGEST = 16, 2048  # turns of a stretch
_LONGEST_TIME = 6e3  # s of a stretch of a sampled loop
_ALIKE = {"continuous": 2e-6, "sampled": 2e-4, "noisy": 0.02}  # averages of two stretches that count as the same
_DRIFT = 0.03  # change between the longest stretches that is still a cycle, and said
_STAYS = 0.1  # of the amplitude, by which its middle may move from one stretch to the next
_MOST_STILL = 8  # stretches of a continuous loop with hardly a turn
_LEAST = {"continuous": 16, "sampled": 32, "noisy": 128}  # turns in the later one


def settle(arm: Arm | RoundsEngine, loop: Loop) -> dict[str, Cycle]:
    """Return each controlled joint's settled motion by simulation alone, from the loop's own, small and large starts.

    Parameters
    ----------
    arm : Arm
        With the effects of its file.
    loop : Loop
        Checked; references at rest in the end, or ramps.

    Raises
    ------
    InputError
        When a reference or an effect drives the loop for ever.
    """
    rounds = Rounds(arm, loop)
    found = {name: answers(rounds, settle_from(rounds, place)) for name, place in starts(rounds).items()}
    moves = {entry.joint: rounds.rate(rounds.index(entry.joint)) != 0.0 for entry in loop.joints}
    return {name: gather(found, name, moves[name]) for name in moves}


def settle_from(rounds: Rounds, place: Place) -> Ending:
    """Return what a loop settles on from a place.

    Where some joints settle and others do not, as one that sticks for long and is shaken loose by others, the ending
    says which. One that is left behind for good, by its drive or by what it is pressed into, is not waited for.
    """
    kind = "noisy" if rounds.noisy else "sampled" if rounds.sampled else "continuous"
    before: Floats | None = None
    last: Floats | None = None
    turns, still, seconds = _FIRST, 0, 25.0
    places, left = [place], dict[int, str]()
    while turns <= _LONGEST and (not rounds.sampled or seconds <= _LONGEST_TIME):
        done = _stretch(rounds, place, turns, seconds)
        if done.why not in ("enough", "end"):
            return _stopped(done.why, done.place)
        span, place = done.place.time - place.time, done.place
        places.append(place)
        left = left_behind(rounds, places, done.turns, left)
        if len(done.turns) < 4:
            still, before, last = still + 1, None, None  # what moved before has passed
            alone = bool(left) and _stand(rounds, place, left)
            if len(done.turns) == 0 and (alone or (still > 3 and not _breaks_away(rounds))):
                return Ending("rest", place, left=left)
            if still > _MOST_STILL and not rounds.sampled:
                break
            seconds *= 4.0
            continue
        if all_die(rounds, place, done.turns, left):
            if (way := ahead(rounds, place)) <= 0.0:
                return Ending("rest", place, left=left)
            place, before = rounds.run(place, NONE, duration=way, quiet=False).place, None
            places = [place]
            continue
        now = _averages(rounds, done.turns)
        enough = max(len(done.turns[done.turns["joint"] == j]) for j in range(rounds.n)) >= _LEAST[kind]
        moving = _moving(rounds, done) - left.keys()
        if before is not None and enough and moving and moving <= _alike(now, before, _ALIKE[kind]):
            status = "ok" if kind == "continuous" else "mean over its rounds"
            if (way := ahead(rounds, place)) <= 0.0:
                return Ending("roughly", place, done.turns, span, status=status, left=left)
            place, before = rounds.run(place, NONE, duration=way, quiet=False).place, None
            places = [place]
            continue
        last, before = before, now
        turns, seconds = 2 * turns, max(seconds, 1.5 * span * 2.0)
    known: frozenset[int] = frozenset() if last is None or before is None else _alike(before, last, _DRIFT)
    if not known or last is None or before is None:
        return Ending("undetermined", place, status="not settled in the longest simulation", left=left)
    rows = sorted(known)
    off = float(np.max(np.abs(before[rows, :2] / last[rows, :2] - 1.0)))
    told = f"mean over its rounds; amplitude or period still changes by {100.0 * off:.2g} %"
    return Ending("roughly", place, done.turns, span, status=told, open=_moving(rounds, done) - known, left=left)


def _moving(rounds: Rounds, done: Stretch) -> frozenset[int]:
    """Return the joints that moved in a stretch, or will: they stick and wind up."""
    moved = {
        int(j)
        for j in np.unique(done.turns["joint"])
        for mine in [done.turns[done.turns["joint"] == j]]
        if mine["high"].max() - mine["low"].min() > 2.0 * TINY
    }
    return winding(rounds, done.place, TINY) | moved


def _stretch(rounds: Rounds, place: Place, turns: int, seconds: float) -> Stretch:
    return follow(rounds, place, ANY, turns, seconds if rounds.sampled or rounds.passes else 1e7)


def _stopped(why: str, place: Place) -> Ending:
    kind = {"quiet": "rest", "unbounded": "unbounded"}.get(why, "undetermined")
    return Ending(kind, place, status="ok" if kind != "undetermined" else STOPPED.get(why, why))


def _stand(rounds: Rounds, place: Place, left: Mapping[int, str]) -> bool:
    """Tell whether all but the joints that are ``left`` behind stand still, or slide along their ramps, for good."""
    velocity = place.values[rounds.layout.state][rounds.n : 2 * rounds.n]
    others = [rounds.index(entry.joint) for entry in rounds.loop.joints if rounds.index(entry.joint) not in left]
    return not waiting(rounds, place) - left.keys() and all(abs(velocity[j] - rounds.rate(j)) < CREEP for j in others)


def _breaks_away(rounds: Rounds) -> bool:
    """Whether a joint that sticks may break away later, as an integral grows."""
    return any(entry.ki > 0.0 or rounds.rate(rounds.index(entry.joint)) != 0.0 for entry in rounds.loop.joints)


def _alike(now: Floats, before: Floats, share: float) -> frozenset[int]:
    """Return the joints whose averages of two stretches are known and the same."""
    sizes = np.isclose(now[:, :2], before[:, :2], rtol=share, atol=1e-3 * TINY).all(axis=1)
    stays = np.abs(now[:, 3] - before[:, 3]) <= _STAYS * now[:, 0]  # what creeps on while it trembles is no cycle
    stuck = np.isclose(now[:, 2], before[:, 2], rtol=0.0, atol=share)
    return frozenset(np.flatnonzero(sizes & stays & stuck).tolist())


def _averages(rounds: Rounds, turns: np.ndarray) -> Floats:
    """Return amplitude, period, share of time stuck and middle of each joint, weighted over its rounds."""
    out = np.full((rounds.n, 4), np.nan)
    for j in np.unique(turns["joint"]).astype(int):
        mine = whole_rounds(turns[turns["joint"] == j])
        if len(mine) < 3:
            continue
        amplitude, period = weighted(0.5 * (mine["high"] - mine["low"])[1:]), weighted(np.diff(mine["time"]))
        middle = weighted(0.5 * (mine["high"] + mine["low"])[1:])
        out[j] = amplitude, period, weighted(mine["stuck"][1:]) / period, middle
    return out
