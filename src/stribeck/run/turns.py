"""Positions that a counter begins anew after each turn, put together again."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stribeck.run.values import Floats

NEAR = 0.5  # rad, that a step may be off whole turns: a joint moves less from sample to sample


def turned_on(q: Floats) -> tuple[Floats, NDArray[np.int_]]:
    """Return positions without leaps by whole turns, and how many leaps there were.

    Parameters
    ----------
    q : array (N, n)
        Recorded positions, rad.

    Returns
    -------
    q : array (N, n)
        In the turn of the first sample, and on from there; the same array where nothing leaps.
    leaps : array (n,) of int
        Of each joint.
    """
    step = np.diff(q, axis=0)
    turns = np.rint(step / (2.0 * np.pi))
    turns[np.abs(step - 2.0 * np.pi * turns) > NEAR] = 0.0
    leaps = np.count_nonzero(turns, axis=0)
    if not leaps.any():
        return q, leaps
    joined = q.copy()
    joined[1:] -= 2.0 * np.pi * np.cumsum(turns, axis=0)
    return joined, leaps
