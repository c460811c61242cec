"""Noise of a recorded position, read off the part of its spectrum where an arm cannot move."""

from __future__ import annotations

import numpy as np
from scipy import signal

BAND = (0.7, 0.98)  # share of the Nyquist frequency in which noise is looked for


def position_noise(position: np.ndarray, sample_time: float, resolution: float | None = None) -> float:
    """Return the standard deviation of white noise on a position record, rad.

    Parameters
    ----------
    position : array (N,)
        Recorded position, rad, uniform in time.
    sample_time : float
        s.
    resolution : float or None
        Encoder resolution, rad, where known; else the smallest step of the record tells it.

    Notes
    -----
    The median of the periodogram in the upper band is robust against resonances; quantisation gives at least
    resolution / sqrt(12) (Widrow & Kollar 2008, *Quantization Noise*), also where the record hardly moves.
    """
    frequency, density = signal.welch(
        np.diff(position, 2), fs=1.0 / sample_time, nperseg=min(512, len(position) - 2), detrend="constant"
    )
    nyquist = 0.5 / sample_time
    band = (frequency > BAND[0] * nyquist) & (frequency < BAND[1] * nyquist)
    gain = (2 * np.sin(np.pi * frequency[band] * sample_time)) ** 4  # of the second difference
    white = np.sqrt(float(np.median(density[band] / gain)) * nyquist)
    step = resolution if resolution else smallest_step(position)
    return float(max(white, step / np.sqrt(12.0), 1e-12))


def smallest_step(position: np.ndarray) -> float:
    """Return the quantum of a record (rad), or 0 where its values lie on no grid."""
    steps = np.abs(np.diff(position))
    steps = steps[steps > 1e-12]
    if len(steps) < 8:
        return 0.0
    quantum = float(np.quantile(steps, 0.01))
    multiples = steps / quantum
    off_grid = float(np.mean(np.abs(multiples - np.round(multiples)) > 0.1))
    return quantum if off_grid < 0.05 else 0.0
