"""The table that Section 3 works from: the mean torque of the trials at each velocity, and the break-away torque."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SAME = 0.1  # of the slowest of them, by which trials at one velocity may differ


@dataclass(frozen=True)
class Readings:
    """Mean readings at V velocities: rising ``speed`` (V,), rad/s, ``torque`` (V,), N m; ``break_away``, N m."""

    speed: Floats
    torque: Floats
    break_away: float | None


def average(speed: Floats, torque: Floats) -> Readings:
    """Average the trials at each velocity.

    Parameters
    ----------
    speed, torque : array (P,)
        Of every trial, rad/s and N m; a speed of 0 is a break-away reading.
    """
    at_rest = speed == 0.0
    order = np.argsort(speed[~at_rest], kind="stable")
    moving, level = speed[~at_rest][order], torque[~at_rest][order]
    edges = [0]
    while edges[-1] < len(moving):
        edges.append(int(np.searchsorted(moving, (1.0 + SAME) * moving[edges[-1]], side="right")))
    means = [np.array([values[i:j].mean() for i, j in pairwise(edges)]) for values in (moving, level)]
    return Readings(means[0], means[1], float(torque[at_rest].mean()) if at_rest.any() else None)
