"""The zero-phase filters of recordings, designed once for all runs of one rate.

A run's noise is drawn and filtered over and over, always by the same two filters.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy import signal

DESIGNS = 256  # that are kept
SUMMED = 400  # frequencies
PERIOD = 1 << 14  # samples, in which a roll-off's response has died down


def smoother(cutoff: float, h: float) -> tuple[Callable[[np.ndarray], np.ndarray], float, float]:
    """Return a zero-phase low-pass for positions, and what unit position noise leaves in position and velocity."""
    sos = _butterworth(cutoff, h).copy()  # scipy's filter takes none that is frozen
    left = amplitude(cutoff, h)
    slope = left * 2 * np.pi * frequencies(h)
    passed, gain = float(np.sqrt(np.mean(left**2))), float(np.sqrt(np.mean(slope**2)))

    def smooth(values: np.ndarray) -> np.ndarray:
        pad = min(len(values) - 1, int(3.0 / (cutoff * h)) + 1)
        return np.asarray(signal.sosfiltfilt(sos, values, axis=0, padlen=pad))

    return smooth, passed, gain


def frequencies(h: float) -> np.ndarray:
    """Return those (F,) over which noise that passes a filter is summed up, Hz."""
    return np.linspace(0.0, 0.5 / h, SUMMED)


def amplitude(cutoff: float, h: float) -> np.ndarray:
    """Return what the zero-phase low-pass for positions leaves at each of the frequencies, (F,)."""
    return np.asarray(1.0 / (1.0 + (frequencies(h) / cutoff) ** 6))


@lru_cache(maxsize=DESIGNS)
def low_pass(cutoff: float, h: float, corner: float = math.inf) -> np.ndarray:
    """Return the taps of the analysis filter, of odd length: flat up to the cutoff, Hz, or rolled off from a corner on.

    The roll-off is that of a noise which rises with the square of the frequency, and leaves it even: 3 dB less at the
    corner, the more by the square beyond.
    """
    length = max(int(3.3 / (cutoff * h)) | 1, 3)
    taps = np.asarray(signal.firwin(length, cutoff, fs=1.0 / h, window=("kaiser", 5.0)))
    if math.isfinite(corner):
        wave = np.fft.rfftfreq(PERIOD, h)
        kernel = np.fft.irfft(1.0 / np.sqrt(1.0 + (wave / corner) ** 4), PERIOD)
        taps = np.convolve(taps, np.roll(kernel, length // 2)[:length], mode="same")
    return _frozen(taps / np.sum(taps))


def decimated(values: np.ndarray, taps: np.ndarray, every: int) -> np.ndarray:
    """Return each row (K,) of values filtered, one sample in ``every`` where all taps lie within it.

    Several of them at a time are a product with a matrix that holds the taps at as many places: on a processor, far
    cheaper than one after the other. What is no number makes all of those none.
    """
    count = (values.shape[1] - len(taps)) // every + 1
    if count < 1:
        return np.zeros((len(values), 0))
    many = min(max(1, len(taps) // every), count)
    blocks, rest = divmod(count, many)
    bank = _bank(taps.tobytes(), every, many)
    seen = sliding_window_view(values, len(bank), axis=1)[:, :: many * every][:, :blocks]
    with np.errstate(over="ignore", invalid="ignore"):  # of what has run away
        parts = [(seen @ bank).reshape(len(values), -1)]
        if rest:
            bank = _bank(taps.tobytes(), every, rest)
            parts.append(values[:, blocks * many * every :][:, : len(bank)] @ bank)
    return np.concatenate(parts, axis=1)


@lru_cache(maxsize=DESIGNS)
def _bank(taps: bytes, every: int, many: int) -> np.ndarray:
    """Return a matrix of which each column holds the taps, ``every`` rows further down than the one before."""
    column = np.frombuffer(taps)[::-1]
    bank = np.zeros((len(column) + (many - 1) * every, many))
    for k in range(many):
        bank[k * every : k * every + len(column), k] = column
    return _frozen(bank)


@lru_cache(maxsize=DESIGNS)
def _butterworth(cutoff: float, h: float) -> np.ndarray:
    return _frozen(signal.butter(3, cutoff, fs=1.0 / h, output="sos"))


def _frozen(values: np.ndarray) -> np.ndarray:
    """Return values that many may share: none can change them."""
    values.flags.writeable = False
    return values
