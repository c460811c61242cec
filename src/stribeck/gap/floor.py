"""The noise floor: what encoder noise alone leaves in the residual, measured by adding it once more."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stribeck.arm import Arm
from stribeck.identify.conditioning import Conditioned, condition
from stribeck.identify.residual import Residual
from stribeck.model.path import SignalPath

DRAWS = 2


def noise_floor(
    arm: Arm, path: SignalPath, p: np.ndarray, runs: Sequence[Conditioned], cutoff: float, seed: int
) -> np.ndarray:
    """Return the residual (M, n), N m, that position noise alone causes, as a root mean square over draws.

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
        noisy = [_again(arm, run, cutoff, rng) for run in runs]
        moved, _ = Residual(path, noisy, ())(p)
        total += (moved - clean) ** 2
    return np.asarray(np.sqrt(total / DRAWS))


def _again(arm: Arm, run: Conditioned, cutoff: float, rng: np.random.Generator) -> Conditioned:
    shaken = replace(run.run, q=run.run.q + run.noise * rng.standard_normal(run.run.q.shape))
    return condition(arm, shaken, cutoff, run.noise, thin=True)
