"""Positions that leap and are back within a few rows: a reading that went wrong, and no motion."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from stribeck.run.values import Floats

WIDTH = 7  # rows of a running median: up to three that follow one another are told from the rest
# the quantile of its steps by which a joint is fast, and times that: no motion; where more leap, it is not known why
FAST, FURTHER = 0.99, 10.0


def without_spikes(t: Floats, q: Floats) -> tuple[Floats, NDArray[np.int_]]:
    """Return positions with leaps there and back put in line with the rows around them, and how many rows those were.

    Parameters
    ----------
    t : array (N,)
        s.
    q : array (N, n)
        Recorded positions, rad.

    Returns
    -------
    q : array (N, n)
        The same array where nothing leaps.
    rows : array (n,) of int
        Of each joint.
    """
    fast = np.quantile(np.abs(np.diff(q, axis=0)), FAST, axis=0)
    off = np.abs(q - median_filter(q, (WIDTH, 1), mode="mirror")) > FURTHER * fast
    off[:, fast == 0.0] = False
    rows = np.count_nonzero(off, axis=0)
    if not rows.any():
        return q, rows
    mended = q.copy()
    for j in np.flatnonzero(rows):
        mended[off[:, j], j] = np.interp(t[off[:, j]], t[~off[:, j]], q[~off[:, j], j])
    return mended, rows
