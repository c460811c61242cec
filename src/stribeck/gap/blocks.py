"""Block-robust statistics: residuals of a wrong model are coloured, so whole blocks are the units."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stribeck.identify.conditioning import Conditioned

BLOCK = 1.0  # s, at least
LEAST_BLOCKS = 6


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


def block_sums(values: np.ndarray, block: np.ndarray) -> np.ndarray:
    """Return the sums over blocks (B, ...) of row values (M, ...)."""
    out = np.zeros((int(block.max()) + 1, *values.shape[1:]))
    np.add.at(out, block, values)
    return out


def t_value(differences: np.ndarray) -> float:
    """Return the t value of the mean of block differences (B,); 0 where it cannot be told."""
    if len(differences) < 2:
        return 0.0
    spread = float(np.std(differences, ddof=1))
    mean = float(np.mean(differences))
    if spread <= 0.0:
        return 0.0 if mean == 0.0 else float(np.sign(mean)) * np.inf
    return float(mean / (spread / np.sqrt(len(differences))))


def bayesian_bootstrap(blocks: int, draws: int, rng: np.random.Generator) -> np.ndarray:
    """Return block weights (draws, blocks) of mean 1 (Rubin 1981)."""
    return np.asarray(rng.dirichlet(np.ones(blocks), draws) * blocks)


def correlation_rows(residual: np.ndarray, runs: Sequence[Conditioned], longest: float = 2.0) -> np.ndarray:
    """Return how many rows (n,) count as one: the integrated autocorrelation of a residual (M, n).

    Summed up to its first negative value (Geyer 1992, initial sequence), at most over ``longest`` seconds.
    """
    out = np.ones(residual.shape[1])
    for j in range(residual.shape[1]):
        total, weight = 0.0, 0
        start = 0
        for run in runs:
            rows = len(run.analysis_index)
            r = residual[start : start + rows, j]
            start += rows
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
