"""The frequency of a motion that swings at one alone: a torque of that period is part of it, or from outside."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.signal import lombscargle

from stribeck.identify.conditioning import Conditioned

MOSTLY = 0.9  # of the velocity's power in all runs, that one wave takes of a motion that has a rhythm
SLOWEST, FASTEST = 0.05, 25.0  # Hz
FINENESS = 4  # frequencies looked at, to one that the longest run can tell from the next
ROWS = 2000  # samples of a run that are looked at, at most: any ones, for even steps would fold what is faster
LONGEST = 100.0  # s of a run, from its middle


def rhythm(runs: Sequence[Conditioned], joint: int) -> tuple[float, float]:
    """Return the frequency at which a joint swings, and how far from it others cannot be told, both in Hz.

    Parameters
    ----------
    runs : sequence of Conditioned
    joint : int

    Returns
    -------
    (float, float)
        Zeros for a motion of more than one wave, and for none.

    Notes
    -----
    Of the motion that was asked for, where it is recorded: what shakes an arm that is to rest makes it swing, too.
    Lomb's (1976) periodogram gives the part of each run's power that a wave of its own phase takes.
    """
    asked = [_asked(run, joint) for run in runs]
    power = np.array([float(velocity @ velocity) for _, velocity in asked])
    if not power.sum() > 0.0:
        return 0.0, 0.0
    longest = max(float(np.ptp(time)) for time, _ in asked)
    grid = np.arange(SLOWEST, min(FASTEST, 0.2 / max(run.sample_time for run in runs)), 1.0 / (FINENESS * longest))
    if not len(grid):
        return 0.0, 0.0
    taken = np.zeros(len(grid))
    for (time, velocity), own in zip(asked, power, strict=True):
        if own > 0.0:
            taken += own * lombscargle(time, velocity, 2.0 * np.pi * grid, normalize=True)
    best = int(np.argmax(taken))
    return (float(grid[best]), 1.0 / longest) if taken[best] > MOSTLY * power.sum() else (0.0, 0.0)


def _asked(run: Conditioned, joint: int) -> tuple[np.ndarray, np.ndarray]:
    """Return times (M,), s, and the velocity about its mean (M,), rad/s, as asked for; else as it was."""
    if run.run.q_ref is None:
        time, velocity = run.time, run.velocity[:, joint]
    else:
        time = run.run.t
        velocity = np.gradient(run.run.q_ref[:, joint], time)
    rows = np.flatnonzero(np.abs(time - 0.5 * (time[0] + time[-1])) <= 0.5 * LONGEST)
    if len(rows) > ROWS:
        rows = np.sort(np.random.default_rng(0).choice(rows, ROWS, replace=False))
    return time[rows], velocity[rows] - velocity[rows].mean()
