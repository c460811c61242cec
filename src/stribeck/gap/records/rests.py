"""Long rests before and after a motion: the last moments of each tell all that they tell.

Whoever starts a log and then walks to the arm records minutes of them. They would take their share of the time of
every fit, and of a single recording all that is fitted.
"""

from __future__ import annotations

import numpy as np

from stribeck.identify.braked import WITHIN, window_means
from stribeck.identify.stretches import part
from stribeck.run import Run

KEPT = 2.0  # s of rest on either side
LEAST = 1.0  # s: less is not worth a word


def without_long_rests(run: Run, noise: np.ndarray, notes: list[str]) -> Run:
    """Return the part of a run around which it rests.

    Parameters
    ----------
    run : Run
        On a uniform clock.
    noise : array (n,)
        Of its positions, rad.
    notes : list of str
        Takes a word on what is left out.
    """
    h = run.sample_time
    means, width = window_means(run)
    left, right = (np.flatnonzero(np.any(np.abs(means - end) > WITHIN * noise, axis=1)) for end in means[[0, -1]])
    if not len(left):
        return run
    kept = round(KEPT / h)
    start, stop = max(0, int(left[0]) * width - kept), min(len(run.t), (int(right[-1]) + 1) * width + kept)
    spared = (len(run.t) - (stop - start)) * h
    if spared < LEAST:
        return run
    notes.append(f"{run.name}: {spared:.3g} s of rest before and after its motion are left out")
    return part(run, start, stop)
