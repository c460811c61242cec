"""Noise of a recorded position, read off the part of its spectrum where an arm cannot move."""

from __future__ import annotations

import numpy as np
from scipy import signal

from stribeck.grid import smallest_step

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
        Encoder resolution, rad, where known; the record's own smallest step where that is coarser.

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
    step = max(resolution or 0.0, smallest_step(position)[0])
    return float(max(white, step / np.sqrt(12.0), 1e-12))
