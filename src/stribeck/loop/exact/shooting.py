"""Exact cycles: Newton's method on the event-driven return map, sticking phases and all.

The turns of a sampled loop fall anywhere in the sampling interval. It is followed until its averages stand still, and
from there Newton's method looks for the number of samples after which it repeats (`repeat`).
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stribeck.arm import Arm
from stribeck.loop.cycle import STOPPED, Cycle
from stribeck.loop.exact.ending import Ending, all_die, answers, gather
from stribeck.loop.exact.engine import RoundsEngine
from stribeck.loop.exact.place import Place
from stribeck.loop.exact.repeat import repeated
from stribeck.loop.exact.rest import ahead, deviations, follow
from stribeck.loop.exact.rounds import ANY, NONE, Rounds
from stribeck.loop.exact.section import Fixed, ReturnMap, solve
from stribeck.loop.exact.settle import settle_from
from stribeck.loop.exact.stall import PLACES, left_behind, waiting
from stribeck.loop.exact.starts import starts
from stribeck.loop.exact.turns import TINY, falls, fold_of
from stribeck.simulate import Loop

Floats = NDArray[np.float64]
_A_TURN, _PASSING = 500.0, 10.0  # s that a turn may take beside other joints, and past places that differ
_NEAR = 0.02  # of the cycle's size: so close a motion is drawn in
_NEUTRAL = 1e-6  # so close to 1 a multiplier by differences does not tell whether a cycle is stable
_STRETCHES = (4, 4, 8, 8, 16, 32, 64, 128, 256, 256)  # turns between looks


def shoot(arm: Arm | RoundsEngine, loop: Loop) -> dict[str, Cycle]:
    """Return each controlled joint's cycle, or what else its loop ends in.

    Parameters
    ----------
    arm : Arm
        With the effects of its file.
    loop : Loop
        Checked; references at rest in the end, or ramps.

    Raises
    ------
    InputError
        When a reference or an effect drives the loop for ever, so that it has no cycle of its own.
    """
    rounds = Rounds(arm, loop)
    if rounds.noisy or any(entry.compensation.kind == "dither" for entry in loop.joints):
        what = "encoder noise" if rounds.noisy else "dither"
        told = f"no exact cycle under {what}: see the simulation"
        return {entry.joint: Cycle("undetermined", status=told) for entry in loop.joints}
    endings = {name: ending_of(rounds, place) for name, place in starts(rounds).items()}
    chosen = next((name for name in ("own", "large", "small") if name in endings and endings[name].lasts), "own")
    endings[chosen] = repeated(rounds, endings[chosen])
    found = {name: answers(rounds, ending) for name, ending in endings.items()}
    moves = {entry.joint: rounds.rate(rounds.index(entry.joint)) != 0.0 for entry in loop.joints}
    return {name: gather(found, name, moves[name]) for name in moves}


def ending_of(rounds: Rounds, place: Place) -> Ending:
    """Return what the loop ends in from a place."""
    if rounds.sampled:
        return settle_from(rounds, place)
    history: np.ndarray = np.zeros(0)
    watch, fixed = ANY, None
    places, left = [place], dict[int, str]()
    for turns in _STRETCHES:
        longest = _PASSING * turns if rounds.passes else 1e7 if rounds.n == 1 else _A_TURN * turns
        done = follow(rounds, place, watch, turns, longest)
        place, last = done.place, history[-40:]
        places.append(place)
        left = left_behind(rounds, places, done.turns, left)
        history = done.turns if not len(last) else np.concatenate([last, done.turns])
        if done.why != "enough":
            if watch >= 0 and done.why == "end" and len(done.turns):
                watch = ANY  # that joint has come to rest, others go on
                continue
            if done.why == "end" and all_die(rounds, place, history, left, falls):
                return Ending("rest", place, left=left)
            if done.why == "end" and left:
                return settle_from(rounds, place)
            if done.why == "end" and rounds.passes:
                continue  # it may stick for longer than that
            return replace(_stopped(done.why, place), left=left)
        if watch < 0:
            joints = done.turns["joint"][len(done.turns) // 2 :].astype(int)
            watch = int(np.bincount(joints).argmax())
            if joints[-1] != watch:  # the place must be a turn of the joint that is watched
                continue
        dies = all_die(rounds, place, done.turns, left)
        if (way := ahead(rounds, place)) > 0.0:
            place, watch = rounds.run(place, NONE, duration=way, quiet=False).place, ANY
            places = [place]
            continue
        if dies:
            return Ending("rest", place, left=left)
        if rounds.passes and (len(places) < PLACES or _drifts(rounds, places, watch, done.turns)):
            continue  # it may yet be seen to fall behind
        still = _still(rounds, place, done.turns, left)
        fixed = _attempt(rounds, watch, place, history, fixed, still)
        if fixed is not None and _drawn_in(rounds, watch, place, fixed, still):
            return Ending(
                "periodic", fixed.place, fixed.turns, fixed.period, tuple(fixed.multipliers), watch=watch, left=left,
                still=still,
            )  # fmt: skip
    return settle_from(rounds, place)


def _stopped(why: str, place: Place) -> Ending:
    if why == "quiet":
        return Ending("rest", place)
    if why == "unbounded":
        return Ending("unbounded", place)
    return Ending("undetermined", place, status=STOPPED.get(why, "it does not turn again"))


def _drifts(rounds: Rounds, places: Sequence[Place], watch: int, turns: np.ndarray) -> bool:
    """Tell whether what stands around the arm lets a cycle's error grow from one stretch to the next."""
    mine = turns[turns["joint"] == watch]
    before, now = (deviations(rounds, place)[watch] for place in places[-2:])
    return rounds.engine.meets and bool(abs(now - before) > _NEAR * (mine["high"] - mine["low"]).max())


def _still(rounds: Rounds, place: Place, turns: np.ndarray, left: Collection[int]) -> frozenset[int]:
    """Return the joints that stand still beside others that move: for good, or nothing more is asked of them."""
    modes, waits = place.values[rounds.layout.modes], waiting(rounds, place) - set(left)
    stands = {rounds.index(entry.joint) for entry in rounds.loop.joints} - set(turns["joint"].astype(int))
    return frozenset(j for j in stands if modes[j] == 0.0 and j not in waits)


def _attempt(
    rounds: Rounds, watch: int, place: Place, history: np.ndarray, known: Fixed | None, still: frozenset[int]
) -> Fixed | None:  # fmt: skip
    """Return a stable fixed point near the motion, the one that is known or a new one."""
    if known is not None and _drawn_in(rounds, watch, place, known, still):
        return known
    mine = history[history["joint"] == watch]
    size = 0.5 * float(mine["high"][-4:].max() - mine["low"][-4:].min())
    section = ReturnMap(rounds, watch, place, fold_of(mine["deviation"], 1e-3 * size), still)
    z = section.coordinates(place)
    fixed = solve(section, z, _scale(z, size))
    if fixed is None or abs(fixed.multipliers[0]) > 1.0 - _NEUTRAL:  # as of a joint that sticks and winds up
        return None
    whole = fixed.turns[fixed.turns["joint"] == watch]
    return fixed if 0.5 * float(whole["high"].max() - whole["low"].min()) > TINY else None


def _scale(z: Floats, size: float) -> Floats:
    return np.maximum(np.abs(z), 0.1 * max(size, TINY))


def _drawn_in(rounds: Rounds, watch: int, place: Place, fixed: Fixed, still: frozenset[int]) -> bool:
    section = ReturnMap(rounds, watch, fixed.place, still=still)
    here, there = section.coordinates(place), section.coordinates(fixed.place)
    mine = fixed.turns[fixed.turns["joint"] == watch]
    size = 0.5 * float(mine["high"].max() - mine["low"].min())
    return bool(np.max(np.abs(here - there) / _scale(there, size)) < _NEAR)
