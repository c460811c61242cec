"""What noise on the recorded motion shifts a fit by: noise that is added once more does the same again.

Near a reversal noise hides the sign of the velocity, where friction counts as an interval. What lies within costs
nothing, what lies beyond does: a larger break-away torque over a shorter decay is cheap, a smaller one is not, and
noise pushes the constants that way. Scatter within the recordings does not show it, since it shifts every block alike.
"""

from __future__ import annotations

import numpy as np

from stribeck.identify.conditioning import Conditioned, shaken
from stribeck.identify.map_fit import Fit
from stribeck.identify.problem import Weights
from stribeck.identify.residual import Residual

PAIRS = 2  # of draws
# the noise's own share over that of as much again: 1 where it goes with the noise's variance, 1 / (sqrt(2) - 1) = 2.4
# where with its deviation, as the time near a reversal in which the sign is unsure; 1.6 to 2.1 in 44 recordings
OF_ITSELF = 2.0


def noise_pull(fit: Fit, weights: Weights, residual: Residual, cutoff: float, seed: int = 0) -> np.ndarray:
    """Return what noise changes the gradient of a fit's cost by, (f,), cost over the parameters' own units.

    Parameters
    ----------
    fit, weights : Fit, Weights
    residual : Residual
        That which was fitted, along its own, thinned runs.
    cutoff : float
        Analysis cutoff of the runs, Hz.
    seed : int

    Notes
    -----
    Simulation extrapolation (Cook & Stefanski 1994, J. Am. Stat. Assoc. 89:1314) from one more level of noise. Each
    draw is added and subtracted: what is odd in it, which averages out by itself, cancels.
    """
    clean = _gradient(fit.residual, fit.jacobian, weights)
    total = np.zeros_like(clean)
    for noisier in louder(residual, cutoff, seed):
        total += _gradient(*residual.along(noisier)(fit.p), weights) - clean
    return np.asarray(OF_ITSELF * total / (2 * PAIRS))


def louder(residual: Residual, cutoff: float, seed: int = 0) -> list[list[Conditioned]]:
    """Return the runs of a residual with their noise once more, by 2 PAIRS draws; as :func:`noise_pull`."""
    rng = np.random.default_rng(seed)
    draws = [[rng.standard_normal(run.run.q.shape) for run in residual.runs] for _ in range(PAIRS)]
    arm, either = residual.path.arm, [[sign * draw for draw in own] for own in draws for sign in (1.0, -1.0)]
    return [[shaken(arm, run, cutoff, draw) for run, draw in zip(residual.runs, own, strict=True)] for own in either]


def _gradient(residual: np.ndarray, jacobian: np.ndarray, weights: Weights) -> np.ndarray:
    return np.asarray(np.einsum("mn,mnf->f", residual * weights.scale**2, jacobian))
