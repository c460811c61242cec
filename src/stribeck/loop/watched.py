"""What a plain simulation shows: the swing and the period of its late part, read off the record."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from stribeck.loop.exact.turns import TINY
from stribeck.simulate import Closed

Floats = NDArray[np.float64]

BAND = 0.25  # of the swing: what the error must cross on either side to count as a period
STEADY = 0.05  # of a swing: by so much may that of the later periods differ from that of the earlier ones, and repeat
UNLIKE = 1.2  # the swing over all periods over the mean of one, from which on they are no periods of one cycle
ONWARD = 0.95  # of the error's range: so far from begin to end, it goes one way
FADES = 0.5  # of the largest error: so much smaller in the later half, it dies down
ONE_WAY = (
    0.2  # of the error's range: what it moves on from one third of the time to the next; a third on a straight way
)


def watched(closed: Closed, joint: int, unit: str = "rad/s", *, noisy: bool = False) -> tuple[float, float] | str:
    """Return amplitude (rad) and period (s) of one joint over the second half of a record; words where it has none.

    The words are ``rest``, or why the record does not tell.

    The amplitude is half the peak-to-peak error, the mean over whole periods; one that the record cuts off does not
    count.

    Parameters
    ----------
    closed : Closed
    joint : int
        Its place in the arm.
    unit : str
        Of a velocity of this joint, for the words.
    noisy : bool
        Whether an encoder has noise, under which no two periods are alike.
    """
    half, end = closed.motion.filled // 2, closed.motion.filled
    error, time = _true_error(closed, joint)[half:end], closed.motion.t[half:end]
    if len(error) < 8 or 0.5 * np.ptp(error) < TINY:
        return "rest"
    if np.ptp(closed.motion.q[half:end, joint]) < TINY:
        return "it stands still while its reference moves on"
    if (rate := _trend(error, time)) != 0.0:
        side = "grows" if rate * float(np.mean(error)) > 0.0 else "shrinks"
        return f"its error still {side}, by {abs(rate):.3g} {unit}"
    starts = _crossings(error)
    if len(starts) < 3:
        return _too_short(error, unit.removesuffix("/s"))
    swings = [0.5 * float(np.ptp(error[a : b + 1])) for a, b in pairwise(starts)]
    before, after = (float(np.mean(part)) for part in (swings[: len(swings) // 2], swings[-(len(swings) // 2) :]))
    if abs(after - before) > STEADY * before:
        return f"its swing still {'dies down' if after < before else 'grows'}"
    if not noisy and 0.5 * np.ptp(error[starts[0] : starts[-1] + 1]) > UNLIKE * np.mean(swings):
        return "its swings are not alike"
    return float(np.mean(swings)), float(time[starts[-1]] - time[starts[0]]) / (len(starts) - 1)


def _trend(error: Floats, time: Floats) -> float:
    """Return the mean rate of an error that goes one way all the time, but for little swings, rad/s; 0 of others."""
    thirds = [float(np.mean(part)) for part in np.array_split(error, 3)]
    steps, whole = np.diff(thirds), float(np.ptp(error))
    goes_on = steps[0] * steps[1] > 0.0 and np.abs(steps).min() > ONE_WAY * whole
    return float(steps.sum() / (time[-1] - time[0]) * 1.5) if goes_on else 0.0


def _too_short(error: Floats, unit: str) -> str:
    """Return what is seen where less than two whole periods are: an error that dies down, or goes one way."""
    before, after = (float(np.abs(half).max()) for half in np.array_split(error, 2))
    if after < FADES * before:
        return f"its error still dies down, from {before:.3g} to {after:.3g} {unit}"
    if abs(way := float(error[-1] - error[0])) > ONWARD * np.ptp(error):
        return f"its error still {'grows' if way * float(np.mean(error)) > 0.0 else 'shrinks'}"
    return "less than two whole periods of its motion are seen"


def _true_error(closed: Closed, joint: int) -> Floats:
    return np.asarray(closed.reference[:, joint] - closed.motion.q[:, joint])


def _crossings(error: Floats) -> list[int]:
    """Return the rows at which the error rises through its middle, having been well below it before."""
    middle, swing = 0.5 * (error.max() + error.min()), 0.5 * float(np.ptp(error))
    found, armed = [], False
    for row, value in enumerate(error - middle):
        if value < -BAND * swing:
            armed = True
        elif armed and value > BAND * swing:
            found.append(row)
            armed = False
    return found
