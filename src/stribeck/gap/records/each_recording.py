"""How much of one torque each recording by itself leaves: a slope for each, with a block-robust standard error."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from stribeck.gap.records.blocks import block_sums
from stribeck.identify.conditioning import Conditioned

NOTHING = 1e-300  # squares, of a torque that a recording does not have


def recording_of_rows(runs: Sequence[Conditioned], names: Sequence[str]) -> NDArray[np.int_]:
    """Return the place among some names (M,) of the recording that each row of runs is of."""
    return np.repeat([names.index(run.name) for run in runs], [len(run.analysis_index) for run in runs])


def slope_of_each(
    left: np.ndarray, change: np.ndarray, recording: NDArray[np.int_], block: NDArray[np.int_]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the slopes (R, c) that take most of what is left, their standard errors (R, c), and what then is left.

    Parameters
    ----------
    left : array (M, c)
        Residual, column by column, each over its noise.
    change : array (M, c)
        What a unit of the slope adds to it.
    recording, block : array (M,) of int
        Of each row; those of one recording have one slope, those of one block errors that go together.
    """
    count, rest = int(recording.max()) + 1, np.empty_like(left)
    slope, error = np.zeros((2, count, left.shape[1]))
    for k in range(count):
        own = recording == k
        power = np.maximum(np.sum(change[own] ** 2, axis=0), NOTHING)
        slope[k] = -np.sum(left[own] * change[own], axis=0) / power
        rest[own] = left[own] + slope[k] * change[own]
        error[k] = np.sqrt(np.sum(block_sums(rest[own] * change[own], block[own]) ** 2, axis=0)) / power
    return slope, error, rest
