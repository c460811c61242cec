"""Noise in the accelerations that is too fast for the analysis: at rest friction must not take it for torque.

The motion's filter lets it through, and the analysis takes it out again; but for the interval that friction is at rest,
which cuts off one side of it, sample by sample. What is as fast and larger than noise is motion: the acceleration leaps
where a joint stops or breaks away.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter1d

from stribeck.identify.filters import amplitude, frequencies

CALM = 2.0  # of the analysis cutoff, where half of the acceleration is too fast
NOISE = 3.0  # standard deviations of it, beyond which it is motion


def flutter(acceleration: np.ndarray, noise: np.ndarray, cutoff: float, analysis: float, h: float) -> np.ndarray:
    """Return the noise in smoothed accelerations (N, n) that the analysis does not see, rad/s^2.

    Parameters
    ----------
    acceleration : array (N, n)
        Of positions that passed the motion's filter (:func:`stribeck.identify.filters.smoother`).
    noise : array (n,)
        Standard deviation of the positions' noise before it, rad.
    cutoff, analysis : float
        Of the motion's filter and of the analysis, Hz.
    h : float
        Sample time, s.

    Notes
    -----
    What a Gaussian filter leaves passes it again and is put back (twicing, Tukey 1977, Exploratory Data Analysis): flat
    below its cutoff to the fourth order, and it hardly rings beside a leap.
    """
    calm = CALM * analysis
    if calm >= cutoff:
        return np.zeros_like(acceleration)
    passed = 1.0 - np.sqrt(0.5)  # by one of the two, at that frequency
    width = np.sqrt(-2.0 * np.log(passed)) / (2.0 * np.pi * calm)
    fast = acceleration
    for _ in range(2):
        fast = fast - gaussian_filter1d(fast, width / h, axis=0, mode="nearest")
    angular = 2.0 * np.pi * frequencies(h)
    left = amplitude(cutoff, h) * angular**2 * (1.0 - np.exp(-0.5 * (width * angular) ** 2)) ** 2
    sd = noise * np.sqrt(np.mean(left**2))
    return np.asarray(np.where(np.abs(fast) <= NOISE * sd, fast, 0.0))
