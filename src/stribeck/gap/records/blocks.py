"""Block-robust statistics: residuals of a wrong model are coloured, so whole blocks are the units."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stribeck.identify.blocks import BLOCK, block_of_rows, correlation_rows
from stribeck.identify.conditioning import Conditioned

__all__ = ["BLOCK", "bayesian_bootstrap", "block_of_rows", "block_sums", "correlation_rows", "resampled", "t_value"]

LEAST_BLOCKS = 6  # of an interval: one block alone, drawn as often as one likes, gives one of no width


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


def enough_blocks(runs: Sequence[Conditioned]) -> np.ndarray:
    """Return the block (M,) of every analysis row: blocks of a second, or shorter ones where these would be few."""
    seconds = sum(len(run.analysis_index) * run.decimation * run.sample_time for run in runs)
    length, row = min(BLOCK, seconds / (LEAST_BLOCKS + 1e-6)), min(run.decimation * run.sample_time for run in runs)
    block = block_of_rows(runs, length)
    while int(block.max()) + 1 < LEAST_BLOCKS and length > 2.0 * row:  # each run has whole ones
        length *= 0.8
        block = block_of_rows(runs, length)
    return block


def resampled(runs: Sequence[Conditioned], draws: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the block (M,) of every analysis row, and weights (draws, blocks) by which blocks are drawn again."""
    block = enough_blocks(runs)
    return block, bayesian_bootstrap(int(block.max()) + 1, draws, np.random.default_rng(seed))
