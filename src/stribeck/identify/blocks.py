"""Rows of a residual that hang together: blocks that count as independent, and how many rows count as one."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from scipy.ndimage import uniform_filter1d

from stribeck.identify.conditioning import Conditioned

BLOCK = 1.0  # s, at least


def block_of_rows(runs: Sequence[Conditioned], length: float = BLOCK) -> np.ndarray:
    """Return the block number (M,) of every analysis row; blocks never span two runs."""
    numbers = []
    count = 0
    for run in runs:
        rows = len(run.analysis_index)
        step = run.decimation * run.sample_time
        blocks = max(1, int(rows * step / length))
        numbers.append(count + np.minimum(np.arange(rows) * blocks // max(rows, 1), blocks - 1))
        count += blocks
    return np.concatenate(numbers)


def over_neighbours(power: np.ndarray, runs: Sequence[Conditioned], count: int) -> np.ndarray:
    """Return the rows (M, n) of all runs, each the mean of so many neighbours of its run."""
    edges = np.cumsum([0, *(len(run.analysis_index) for run in runs)])
    parts = [uniform_filter1d(power[i:k], count, axis=0, mode="nearest") for i, k in pairwise(edges)]
    return np.concatenate(parts)


def correlation_rows(residual: np.ndarray, runs: Sequence[Conditioned], longest: float = 2.0) -> np.ndarray:
    """Return how many rows (n,) count as one: the integrated autocorrelation of a residual (M, n).

    Summed up to its first negative value (Geyer 1992, initial sequence), at most over ``longest`` seconds. Runs that
    leave nothing at all, as of a joint that a brake holds, tell nothing.
    """
    out = np.ones(residual.shape[1])
    for j in range(residual.shape[1]):
        total, weight = 0.0, 0
        start = 0
        for run in runs:
            rows = len(run.analysis_index)
            r = residual[start : start + rows, j]
            start += rows
            if not r.any():
                continue
            total += rows * _integrated(r, int(longest / (run.decimation * run.sample_time)))
            weight += rows
        out[j] = max(1.0, total / max(weight, 1))
    return out


def _integrated(r: np.ndarray, longest: int) -> float:
    if len(r) < 4:
        return 1.0
    size = 1 << (2 * len(r) - 1).bit_length()
    power = np.abs(np.fft.rfft(r, size)) ** 2
    rho = np.fft.irfft(power)[: min(longest, len(r) // 2) + 1]
    if rho[0] <= 0.0:
        return 1.0
    rho = rho / rho[0]
    negative = np.flatnonzero(rho < 0.0)
    stop = int(negative[0]) if len(negative) else len(rho)
    return float(1.0 + 2.0 * np.sum(rho[1:stop]))
