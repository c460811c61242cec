"""Positions that a counter begins anew after each turn, put together again."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stribeck.run.values import Floats

TURN = 2.0 * np.pi
NEAR = 0.5  # rad, that a step may be off whole turns: a joint moves less from sample to sample
MISSING = 1.5  # median steps: rows are missing in a longer one
SPAN = 4  # rows over which a speed is told, and as many more of which the middle one is taken
FORESEEN = np.pi  # rad, that a joint may go where rows are missing: beyond, speeds around tell no turn


def turned_on(q: Floats, t: Floats) -> tuple[Floats, NDArray[np.int_]]:
    """Return positions without leaps by whole turns, and how many leaps there were.

    Where rows are missing, a joint may have gone on besides, by the speeds before and after.

    Parameters
    ----------
    q : array (N, n)
        Recorded positions, rad.
    t : array (N,)
        Times, increasing, s.

    Returns
    -------
    q : array (N, n)
        In the turn of the first sample, and on from there; the same array where nothing leaps.
    leaps : array (n,) of int
        Of each joint.
    """
    step = np.diff(q, axis=0)
    turns = np.rint(step / TURN)
    unclear = np.abs(step - TURN * turns) > NEAR
    turns[unclear] = 0.0
    time = np.diff(t)
    missing = time > MISSING * np.median(time)
    if (unclear & missing[:, None]).any() and np.count_nonzero(~missing) > SPAN:
        gone = _gone(step - TURN * turns, time, missing)
        more = np.rint((step[missing] - gone) / TURN)
        told = (np.abs(step[missing] - gone - TURN * more) <= NEAR) & (np.abs(gone) <= FORESEEN)
        turns[missing] = np.where(unclear[missing] & told, more, turns[missing])
    leaps = np.count_nonzero(turns, axis=0)
    if not leaps.any():
        return q, leaps
    joined = q.copy()
    joined[1:] -= TURN * np.cumsum(turns, axis=0)
    return joined, leaps


def _gone(step: Floats, time: Floats, missing: NDArray[np.bool_]) -> Floats:
    """Return how far joints go where rows are missing, (K, n), rad, by the mean of their speeds before and after.

    Parameters
    ----------
    step : array (N, n)
        From sample to sample, rad.
    time, missing : array (N,)
        How long each takes, s, and whether rows are missing there.
    """
    way = np.cumsum(np.insert(step[~missing], 0, 0.0, axis=0), axis=0)
    clock = np.cumsum(np.insert(time[~missing], 0, 0.0))
    speed = (way[SPAN:] - way[:-SPAN]) / (clock[SPAN:] - clock[:-SPAN])[:, None]
    at = np.cumsum(~missing)[missing]  # the row before, of those that are left
    rows = np.arange(SPAN + 1)
    around = (at[:, None] + side + rows for side in (-2 * SPAN, 0))
    before, after = (np.median(speed[np.clip(near, 0, len(speed) - 1)], axis=1) for near in around)
    return np.asarray(0.5 * (before + after) * time[missing][:, None])
