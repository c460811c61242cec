"""The noise floor: what encoder noise and our own filters leave in the residual, both measured.

Noise is added once more to see what it does; what filters do is in :mod:`stribeck.identify.blur`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stribeck.arm import Arm
from stribeck.gap.records.spread import LEAST
from stribeck.identify.blocks import over_neighbours
from stribeck.identify.blur import blur
from stribeck.identify.conditioning import Conditioned, shaken
from stribeck.identify.residual import Residual
from stribeck.model.path import SignalPath

DRAWS = 3
NEIGHBOURS = 7  # rows, over which a row's noise is averaged
TINY = 1e-12  # N m


def noise_floor(
    arm: Arm, path: SignalPath, p: np.ndarray, runs: Sequence[Conditioned], cutoff: float, seed: int
) -> np.ndarray:
    """Return the residual (M, n), N m, that position noise and filtering cause, as a root mean square.

    Parameters
    ----------
    arm : Arm
    path, p : SignalPath, array (p,)
        The model along whose path the noise travels: velocity signs, acceleration, states and all.
    runs : sequence of Conditioned
        Their ``noise`` is drawn again and added to the recorded positions.
    cutoff : float
        Analysis cutoff, Hz.
    seed : int
    """
    rng = np.random.default_rng(seed)
    residual = Residual(path, runs, ())
    clean = residual.value(p)
    total = np.zeros_like(clean)
    for _ in range(DRAWS):
        noisy = [shaken(arm, run, cutoff, rng.standard_normal(run.run.q.shape)) for run in runs]
        total += (residual.along(noisy).value(p) - clean) ** 2
    return np.asarray(np.sqrt(total / DRAWS + blur(residual, p, cutoff) ** 2))


def noise_of_rows(
    arm: Arm, path: SignalPath, p: np.ndarray, runs: Sequence[Conditioned], cutoff: float, seed: int
) -> np.ndarray:
    """Return :func:`noise_floor` smoothed over neighbouring rows, at least LEAST of each joint's own.

    Parameters
    ----------
    arm : Arm
    path, p : SignalPath, array (p,)
        The model along whose path the noise travels.
    runs : sequence of Conditioned
    cutoff : float
        Analysis cutoff, Hz.
    seed : int
        Of the noise that is drawn.
    """
    power = noise_floor(arm, path, p, runs, cutoff, seed) ** 2
    even = over_neighbours(power, runs, NEIGHBOURS)
    return np.asarray(np.sqrt(np.maximum(even, LEAST**2 * np.mean(power, axis=0) + TINY**2)))
