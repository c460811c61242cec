"""The zero-phase filters of recordings, designed once for all runs of one rate.

A run's noise is drawn and filtered over and over, always by the same two filters.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from scipy import signal

DESIGNS = 256  # that are kept


def smoother(cutoff: float, h: float) -> tuple[Callable[[np.ndarray], np.ndarray], float, float]:
    """Return a zero-phase low-pass for positions, and what unit position noise leaves in position and velocity."""
    sos = _butterworth(cutoff, h).copy()  # scipy's filter takes none that is frozen
    frequency = np.linspace(0.0, 0.5 / h, 400)
    amplitude = 1.0 / (1.0 + (frequency / cutoff) ** 6)
    slope = amplitude * 2 * np.pi * frequency
    passed, gain = float(np.sqrt(np.mean(amplitude**2))), float(np.sqrt(np.mean(slope**2)))

    def smooth(values: np.ndarray) -> np.ndarray:
        pad = min(len(values) - 1, int(3.0 / (cutoff * h)) + 1)
        return np.asarray(signal.sosfiltfilt(sos, values, axis=0, padlen=pad))

    return smooth, passed, gain


@lru_cache(maxsize=DESIGNS)
def low_pass(cutoff: float, h: float) -> np.ndarray:
    """Return the taps of the analysis filter, of odd length."""
    length = int(3.3 / (cutoff * h)) | 1
    taps = signal.firwin(max(length, 3), cutoff, fs=1.0 / h, window=("kaiser", 5.0))
    return _frozen(np.asarray(taps))


@lru_cache(maxsize=DESIGNS)
def _butterworth(cutoff: float, h: float) -> np.ndarray:
    return _frozen(signal.butter(3, cutoff, fs=1.0 / h, output="sos"))


def _frozen(values: np.ndarray) -> np.ndarray:
    """Return values that many may share: none can change them."""
    values.flags.writeable = False
    return values
