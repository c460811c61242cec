"""A cycle followed along k, Kp or the delay: each value begins where the one before ended."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from stribeck.arm import Arm
from stribeck.errors import InputError
from stribeck.loop.cycle import Cycle
from stribeck.loop.exact.ending import Ending, answers
from stribeck.loop.exact.engine import RoundsEngine
from stribeck.loop.exact.place import Place
from stribeck.loop.exact.rounds import Rounds
from stribeck.loop.exact.section import Fixed, ReturnMap, solve
from stribeck.loop.exact.settle import settle_from
from stribeck.loop.exact.shooting import ending_of
from stribeck.loop.exact.starts import starts
from stribeck.simulate import JointLoop, Loop

Parameter = Literal["k", "kp", "delay"]
Values = Sequence[float] | NDArray[np.float64]


def continue_in(
    arm: Arm | RoundsEngine, loop: Loop, joint: str, parameter: Parameter, values: Values
) -> list[Cycle]:  # fmt: skip
    """Return the joint's cycle at each value, followed from the one before it.

    A continuous loop is followed, through unstable cycles too, by Newton's method on its return map; a sampled one by
    its motion, without multipliers. Where nothing is followed any more (at a fold, or where the cycle ends in rest) the
    loop is started anew, from its large start first, so that the next branch is found; where no start leads to a cycle
    the answer is that of its own.

    Parameters
    ----------
    arm : Arm
    loop : Loop
    joint : str
    parameter : str
        ``k`` (compensation over true friction), ``kp`` (N m/rad, at the same damping ratio where ``kv`` is critical)
        or ``delay`` (whole samples).
    values : sequence of V floats
        In the order in which they are followed.

    Raises
    ------
    InputError
        When a value is out of range, or the parameter has no meaning in this loop.
    """
    engine = arm if isinstance(arm, RoundsEngine) else RoundsEngine(arm)
    entry = next((e for e in loop.joints if e.joint == joint), None)
    if entry is None:
        raise InputError("the loop does not control this joint", repr(joint), "name one that it controls")
    changed = (_changed(entry, parameter, float(value), loop) for value in values)
    joints = (tuple(new if e is entry else e for e in loop.joints) for new in changed)
    return continue_through(engine, (replace(loop, joints=each) for each in joints), joint)


def continue_through(engine: RoundsEngine, loops: Iterable[Loop], joint: str) -> list[Cycle]:
    """Return the joint's cycle in each of the loops, followed from one to the next as `continue_in` does."""
    cycles: list[Cycle] = []
    known: Ending | None = None
    for loop in loops:
        rounds = Rounds(engine, loop)
        known = _next(rounds, known)
        cycles.append(answers(rounds, known)[joint])
    return cycles


def _changed(entry: JointLoop, parameter: Parameter, value: float, loop: Loop) -> JointLoop:
    if not np.isfinite(value) or value < 0.0 or (parameter == "kp" and value == 0.0):
        raise InputError(f"{parameter} is out of range", f"{value:g}", "give values above zero")
    if parameter == "k":
        return replace(entry, compensation=replace(entry.compensation, ratio=value))
    if parameter == "kp":
        return replace(entry, kp=value)
    if loop.sample_time == 0.0:
        raise InputError(
            "a delay in samples needs a sampled controller", "sample_time = 0", "give a sample_time above 0"
        )
    if value != int(value):
        raise InputError("delay is not a number of whole samples", f"{value:g}", "give whole numbers")
    return replace(entry, delay_samples=int(value))


def _next(rounds: Rounds, known: Ending | None) -> Ending:
    if known is not None and known.kind == "periodic" and not rounds.sampled:
        fixed = _corrected(rounds, known.watch, known)
        if fixed is not None:
            return Ending(
                "periodic", fixed.place, fixed.turns, fixed.period, tuple(fixed.multipliers), watch=known.watch,
                left=known.left, still=known.still,
            )  # fmt: skip
    if known is not None and known.lasts and rounds.sampled:
        ending = settle_from(rounds, _with_past(rounds, known.place))
        if ending.lasts:
            return ending
    return _anew(rounds)


def _with_past(rounds: Rounds, place: Place) -> Place:
    """Return a place with as many past commands as this loop's delay wants."""
    missing = rounds.history - place.past.shape[1]
    if missing > 0:
        return replace(place, past=np.pad(place.past, ((0, 0), (missing, 0), (0, 0)), "edge"))
    return replace(place, past=place.past[:, -rounds.history :])


def _anew(rounds: Rounds) -> Ending:
    """Return the first motion that lasts from a large, the own and a small start; else what the own start ends in."""
    places = starts(rounds)
    found = {}
    for name in ("large", "own", "small"):
        if name in places:
            found[name] = ending_of(rounds, places[name])
            if found[name].lasts:
                return found[name]
    return found["own"]


def _corrected(rounds: Rounds, watch: int, known: Ending) -> Fixed | None:
    """Return the fixed point of this loop's map near the one that is known, None where it is lost."""
    mine = known.turns[known.turns["joint"] == watch]
    size = 0.5 * float(np.ptp([mine["low"].min(), mine["high"].max()])) if len(mine) else 0.0
    if size == 0.0:
        return None
    section = ReturnMap(rounds, watch, known.place, len(mine), known.still)
    z = section.coordinates(known.place)
    fixed = solve(section, z, np.maximum(np.abs(z), 0.1 * size))
    if fixed is None:
        return None
    after = fixed.turns[fixed.turns["joint"] == watch]
    now = 0.5 * float(np.ptp([after["low"].min(), after["high"].max()]))
    return fixed if 1e-3 * size < now < 10.0 * size else None
