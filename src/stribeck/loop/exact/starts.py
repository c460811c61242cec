"""Where to start a loop from, so that every cycle that draws it in is found: its own start, a small and a large one."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stribeck.loop.exact.place import Place
from stribeck.loop.exact.rounds import NONE, Rounds
from stribeck.simulate import JointLoop

SMALL, LARGE = 0.02, 20.0  # of the error at which the drive just moves the joint
_LEAST, _FREE = 1e-5, 1e-3  # rad: below the least a joint is as good as free, and measured by the other


def starts(rounds: Rounds) -> dict[str, Place]:
    """Return the places ``own`` (the loop file's, at its last step), ``large`` and ``small``.

    Errors are measured by that at which the proportional torque breaks the joint away, with what the compensation
    adds. Along a ramp, small is sliding along with the reference, where it would stay but for a thousandth.
    """
    large: dict[str, float] = {}
    small: dict[str, float] = {}
    rates: dict[str, float] = {}
    for entry in rounds.loop.joints:
        j = rounds.index(entry.joint)
        axis, rate = rounds.axes[j], rounds.rate(j)
        ratio = axis.ratio if entry.compensation.kind == "feedback" else 0.0
        unit = float(moving_error(np.array(rounds.break_away(j) / entry.kp)))
        large[entry.joint] = LARGE * max(1.0, ratio) * unit
        small[entry.joint] = SMALL * unit
        if rate != 0.0:
            large[entry.joint] = 0.0
            small[entry.joint] = 1.001 * _steady(rounds, j, entry.kp, ratio, rate)
            rates[entry.joint] = rate
    found = {"own": own_start(rounds), "small": rounds.start(small, rates), "large": rounds.start(large)}
    if all(rounds.rate(rounds.index(entry.joint)) != 0.0 for entry in rounds.loop.joints):
        del found["large"]  # standing still behind a ramp is the loop's own start
    return found


def moving_error(error: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the error (rad) by which starts are measured, given that at which the drive just moves the joint."""
    return np.where(error < _LEAST, _FREE, error)


def own_start(rounds: Rounds) -> Place:
    """Return where the loop is at its last step within the duration, having begun as the loop file says."""
    place = rounds.start({})
    steps = {entry.joint: entry.reference.within(rounds.given.duration) for entry in _stepping(rounds)}
    now = {entry.joint: entry.start for entry in _stepping(rounds)}
    for time in sorted({time for step in steps.values() for time in step.times}):
        left = _until(rounds, place, time)
        if left > 0.0:
            done = rounds.aiming(now).run(place, NONE, duration=left, quiet=False)
            place = replace(done.place, values=rounds.layout.anew(done.place.values))
            if done.why != "end":
                break
        now |= {name: step.values[step.times.index(time)] for name, step in steps.items() if time in step.times}
    return place


def _stepping(rounds: Rounds) -> list[JointLoop]:
    return [entry for entry in rounds.given.joints if entry.reference.kind == "steps"]


def _until(rounds: Rounds, place: Place, time: float) -> float:
    """Return how long to run for a step at a time to come next, s; a sampled controller sees it at a sample."""
    if not rounds.sampled:
        return time - place.time
    ts = rounds.loop.sample_time
    sample = max(math.ceil(time / ts), 0)
    sample += (ts * sample < time) - (sample > 0 and ts * (sample - 1) >= time)
    return (sample - place.sample + 0.5) * ts if sample > place.sample else 0.0


def _steady(rounds: Rounds, j: int, kp: float, ratio: float, rate: float) -> float:
    """Return the error with which a joint slides along its ramp, the arm's other torques left out."""
    axis = rounds.axes[j]
    c0, c1, c2, alpha = axis.friction[:4] if rate > 0.0 else axis.friction[4:]
    level = c0 + c1 * 2.718281828459045 ** (-abs(rate) / alpha) + c2 * abs(rate)
    share = ratio if axis.kind == 2 else axis.ratio if axis.kind == 1 else 0.0
    return float((1.0 - share) * level / kp) * (1.0 if rate > 0.0 else -1.0)
