"""The table that Section 3 works from: the mean torque of the trials at each velocity, and the break-away torque."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SAME = 0.1  # relative: trials at velocities no farther apart are trials at one velocity


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
    group = np.concatenate([[0], np.cumsum(np.diff(moving) > SAME * moving[:-1])]) if len(moving) else np.zeros(0, int)
    count = int(group[-1]) + 1 if len(group) else 0
    means = [np.array([values[group == k].mean() for k in range(count)]) for values in (moving, level)]
    return Readings(means[0], means[1], float(torque[at_rest].mean()) if at_rest.any() else None)
