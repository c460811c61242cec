"""The noise floor: what encoder noise and our own filters leave in the residual, both measured.

Noise is added once more to see what it does. Filters round the corners of a stick-slip motion; the residual's change
when the motion's filter is made softer shows how much, and an effect of the arm does not change with it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stribeck.arm import Arm
from stribeck.identify.conditioning import Conditioned, condition
from stribeck.identify.residual import Residual
from stribeck.model.path import SignalPath

DRAWS = 2
SOFTER = 0.6  # of the motion filter's cutoff
BLUR = 1.0 / SOFTER**2 - 1.0  # change at that cutoff over the error at the full one, where it falls with its square
FELT = 0.5  # of the blur is left in a re-tuned residual: measured on twelve recordings without an effect


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
        noisy = [_again(arm, run, cutoff, rng) for run in runs]
        moved, _ = Residual(path, noisy, ())(p)
        total += (moved - clean) ** 2
    soft = [condition(arm, run.run, cutoff, run.noise, thin=True, sharpness=SOFTER) for run in runs]
    blurred, _ = Residual(path, soft, ())(p)
    return np.asarray(np.sqrt(total / DRAWS + (FELT * (blurred - clean) / BLUR) ** 2))


def _again(arm: Arm, run: Conditioned, cutoff: float, rng: np.random.Generator) -> Conditioned:
    shaken = replace(run.run, q=run.run.q + run.noise * rng.standard_normal(run.run.q.shape))
    return condition(arm, shaken, cutoff, run.noise, thin=True)
