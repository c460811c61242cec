"""The noise floor: what encoder noise and our own filters leave in the residual, both measured.

Noise is added once more to see what it does. Filters round the corners of a stick-slip motion; the residual's change
when the motion's filter is made softer shows how much, and an effect of the arm does not change with it.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from scipy.ndimage import uniform_filter1d

from stribeck.arm import Arm
from stribeck.gap.records.spread import LEAST
from stribeck.identify.conditioning import Conditioned, condition, shaken
from stribeck.identify.residual import Residual
from stribeck.model.path import SignalPath

DRAWS = 3
NEIGHBOURS = 7  # rows, over which a row's noise is averaged
TINY = 1e-12  # N m
SOFTER = 0.6  # of the motion filter's cutoff
BLUR = 1.0 / SOFTER**2 - 1.0  # change at that cutoff over the error at the full one, where it falls with its square
# of the blur is left in a re-tuned residual: of 145 recordings of five plants without an effect it leaves nine of ten
# within 1.3 floors; of those below 250 Hz, where most is blur, 0.15 would leave three of four within 1.75
FELT = 0.6


def noise_floor(
    arm: Arm, path: SignalPath, p: np.ndarray, runs: Sequence[Conditioned], cutoff: float, seed: int
) -> np.ndarray:
    """Return the residual (M, n), N m, that position noise and filtering cause, as a root mean square.

    Parameters
    ----------
    path, p : SignalPath, array (p,)
        The model along whose path the noise travels: velocity signs, acceleration, states and all.
    runs : sequence of Conditioned
        Their ``noise`` is drawn again and added to the recorded positions.
    cutoff : float
        Analysis cutoff, Hz.
    seed : int
    """
    rng = np.random.default_rng(seed)
    clean, _ = Residual(path, runs, ())(p)
    total = np.zeros_like(clean)
    for _ in range(DRAWS):
        noisy = [shaken(arm, run, cutoff, rng.standard_normal(run.run.q.shape)) for run in runs]
        moved, _ = Residual(path, noisy, ())(p)
        total += (moved - clean) ** 2
    soft = [condition(arm, run.run, cutoff, run.noise, thin=True, sharpness=SOFTER).as_recorded(run) for run in runs]
    blurred, _ = Residual(path, soft, ())(p)
    return np.asarray(np.sqrt(total / DRAWS + (FELT * (blurred - clean) / BLUR) ** 2))


def noise_of_rows(
    arm: Arm, path: SignalPath, p: np.ndarray, runs: Sequence[Conditioned], cutoff: float, seed: int
) -> np.ndarray:
    """Return :func:`noise_floor` smoothed over neighbouring rows, at least LEAST of each joint's own; as arguments."""
    power = noise_floor(arm, path, p, runs, cutoff, seed) ** 2
    even = over_neighbours(power, runs, NEIGHBOURS)
    return np.asarray(np.sqrt(np.maximum(even, LEAST**2 * np.mean(power, axis=0) + TINY**2)))


def over_neighbours(power: np.ndarray, runs: Sequence[Conditioned], count: int) -> np.ndarray:
    """Return the rows (M, n) of all runs, each the mean of so many neighbours of its run."""
    edges = np.cumsum([0, *(len(run.analysis_index) for run in runs)])
    parts = [uniform_filter1d(power[i:k], count, axis=0, mode="nearest") for i, k in pairwise(edges)]
    return np.concatenate(parts)
