"""Whether both directions of a joint have one friction curve: the F test of a common fit against two."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from stribeck.identify.tustin_fit import CurveFit, fit_curve

Floats = NDArray[np.float64]

CLEAR = 0.01  # probability under which directions that differ so much by chance are taken to differ


def common_curve(readings: Sequence[tuple[Floats, Floats]]) -> CurveFit:
    """Fit one curve to several sets of readings.

    Parameters
    ----------
    readings : sequence of (speed, torque)
        Absolute velocity (P,), rad/s, and friction (P,), N m, of each set.
    """
    speed, torque = (np.concatenate(parts) for parts in zip(*readings, strict=True))
    return fit_curve(speed, torque)


def compare_curves(readings: Sequence[tuple[Floats, Floats]]) -> float:
    """Return the probability that equal curves differ as much as those of two sets of readings (F test).

    Parameters
    ----------
    readings : sequence of two (speed, torque)
        Absolute velocity (P,), rad/s, and friction (P,), N m, of each set.
    """
    common = common_curve(readings)
    apart = sum(fit_curve(*one).chi2 for one in readings)
    spare = common.points - 8
    if spare < 1 or not apart > 0.0:
        return math.nan
    return float(stats.f.sf(max(common.chi2 - apart, 0.0) / 4.0 / (apart / spare), 4, spare))
