"""What a plain simulation shows: the swing and the period of its late part, read off the record."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from stribeck.simulate import Closed

Floats = NDArray[np.float64]

TINY = 1e-6  # rad; a smaller swing is rest
BAND = 0.25  # of the swing: what the error must cross on either side to count as a round
STEADY = 0.05  # of a swing: by so much may that of the later rounds differ from that of the earlier ones, and repeat


def watched(closed: Closed, joint: int) -> tuple[float, float] | str:
    """Return amplitude (rad) and period (s) of one joint (index) over the second half; in words where it has none.

    ``rest``, or what keeps it from saying: it still moves but is not seen to repeat.

    The amplitude is the mean over whole rounds; rounds that are not closed do not count.

    Parameters
    ----------
    closed : Closed
    joint : int
    """
    half, end = closed.motion.filled // 2, closed.motion.filled
    error, time = _true_error(closed, joint)[half:end], closed.motion.t[half:end]
    if len(error) < 8 or 0.5 * np.ptp(error) < TINY:
        return "rest"
    if np.ptp(closed.motion.q[half:end, joint]) < TINY:
        return "it stands still while its reference moves:"
    starts = _crossings(error)
    if len(starts) < 3:
        return "too short to see it repeat:"
    swings = [0.5 * float(np.ptp(error[a : b + 1])) for a, b in pairwise(starts)]
    before, after = (float(np.mean(part)) for part in (swings[: len(swings) // 2], swings[-(len(swings) // 2) :]))
    if abs(after - before) > STEADY * before:
        return f"its swing still {'dies down' if after < before else 'grows'}:"
    return float(np.mean(swings)), float(time[starts[-1]] - time[starts[0]]) / (len(starts) - 1)


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
