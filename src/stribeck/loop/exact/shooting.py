"""Exact cycles: Newton's method on the event-driven return map, sticking phases and all.

The turns of a sampled loop fall anywhere in the sampling interval. It is followed until its averages stand still, and
from there Newton's method looks for the number of samples after which it repeats (`repeat`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stribeck.arm import Arm
from stribeck.loop.cycle import Cycle
from stribeck.loop.exact.ending import Ending, all_die, answers, gather
from stribeck.loop.exact.place import Place
from stribeck.loop.exact.repeat import repeated
from stribeck.loop.exact.rest import ahead, follow
from stribeck.loop.exact.rounds import ANY, NONE, Rounds, RoundsEngine
from stribeck.loop.exact.section import Fixed, ReturnMap, solve
from stribeck.loop.exact.settle import settle_from
from stribeck.loop.exact.starts import starts
from stribeck.loop.exact.turns import TINY, falls, fold_of
from stribeck.simulate import Loop

Floats = NDArray[np.float64]
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
    return {entry.joint: gather(found, entry.joint) for entry in loop.joints}


def ending_of(rounds: Rounds, place: Place) -> Ending:
    """Return what the loop ends in from a place."""
    if rounds.sampled:
        return settle_from(rounds, place)
    history: np.ndarray = np.zeros(0)
    watch, fixed = ANY, None
    for turns in _STRETCHES:
        done = follow(rounds, place, watch, turns, 1e7 if rounds.n == 1 else 2000.0)
        place, last = done.place, history[-40:]
        history = done.turns if not len(last) else np.concatenate([last, done.turns])
        if done.why != "enough":
            if watch >= 0 and done.why == "end" and len(done.turns):
                watch = ANY  # that joint has come to rest, others go on
                continue
            if done.why == "end" and all_die(rounds, place, history, falls):
                return Ending("rest", place)
            return _stopped(done.why, place)
        if watch < 0:
            joints = done.turns["joint"][len(done.turns) // 2 :].astype(int)
            watch = int(np.bincount(joints).argmax())
            if joints[-1] != watch:  # the place must be a turn of the joint that is watched
                continue
        if all_die(rounds, place, done.turns):
            if (way := ahead(rounds, place)) <= 0.0:
                return Ending("rest", place)
            place, watch = rounds.run(place, NONE, duration=way, quiet=False).place, ANY
            continue
        fixed = _attempt(rounds, watch, place, history, fixed)
        if fixed is not None and _drawn_in(rounds, watch, place, fixed):
            return Ending("periodic", fixed.place, fixed.turns, fixed.period, tuple(fixed.multipliers), watch=watch)
    return settle_from(rounds, place)


def _stopped(why: str, place: Place) -> Ending:
    if why == "quiet":
        return Ending("rest", place)
    if why == "unbounded":
        return Ending("unbounded", place)
    return Ending("undetermined", place, status=why if why != "end" else "it does not turn again")


def _attempt(rounds: Rounds, watch: int, place: Place, history: np.ndarray, known: Fixed | None) -> Fixed | None:
    """Return a stable fixed point near the motion, the one that is known or a new one."""
    if known is not None and _drawn_in(rounds, watch, place, known):
        return known
    mine = history[history["joint"] == watch]
    size = 0.5 * float(mine["high"][-4:].max() - mine["low"][-4:].min())
    section = ReturnMap(rounds, watch, place, fold_of(mine["deviation"], 1e-3 * size))
    z = section.coordinates(place)
    fixed = solve(section, z, _scale(z, size))
    if fixed is None or abs(fixed.multipliers[0]) > 1.0 - _NEUTRAL:  # as of a joint that sticks and winds up
        return None
    whole = fixed.turns[fixed.turns["joint"] == watch]
    return fixed if 0.5 * float(whole["high"].max() - whole["low"].min()) > TINY else None


def _scale(z: Floats, size: float) -> Floats:
    return np.maximum(np.abs(z), 0.1 * max(size, TINY))


def _drawn_in(rounds: Rounds, watch: int, place: Place, fixed: Fixed) -> bool:
    section = ReturnMap(rounds, watch, fixed.place)
    here, there = section.coordinates(place), section.coordinates(fixed.place)
    mine = fixed.turns[fixed.turns["joint"] == watch]
    size = 0.5 * float(mine["high"].max() - mine["low"].min())
    return bool(np.max(np.abs(here - there) / _scale(there, size)) < _NEAR)
