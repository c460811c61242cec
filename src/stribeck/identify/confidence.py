"""Confidence intervals that hold when residuals are coloured: the block-robust sandwich."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from stribeck.identify.map_fit import Fit
from stribeck.identify.problem import Weights
from stribeck.model.layout import Entry

FLAT = 0.5  # of the tolerance: deviation and pull of the noise together, from which on a value counts as not identified
DECAY = "alpha"  # known by its ratio
MOST = 50.0  # logarithm of a ratio that is as good as infinite


@dataclass(frozen=True)
class Intervals:
    """95 % intervals of all parameters: ``low``, ``high`` (p,), and which of them the data identified (p,)."""

    low: np.ndarray
    high: np.ndarray
    identified: np.ndarray


def intervals(
    fit: Fit,
    weights: Weights,
    block: np.ndarray,
    level: float = 0.95,
    *,
    pull: np.ndarray | None = None,
    margin: float = 1.0,
) -> Intervals:
    """Return confidence intervals of a fit.

    Parameters
    ----------
    fit : Fit
    weights : Weights
        Those of the fit.
    block : array (M,)
        Block number of each row; scores are summed within blocks, which are taken as independent.
    level : float
        Confidence level.
    pull : array (f,) or None
        What the recordings' noise changes the cost's gradient by (:func:`stribeck.identify.noise_pull.noise_pull`).
        Intervals then reach around both the value and where it would be without noise.
    margin : float
        Factor on what the scatter of the blocks says, the tolerances apart.

    Notes
    -----
    Covariance H^-1 (S + P) H^-1 with H the Gauss-Newton Hessian, S the sum of outer products of block scores and P
    the prior's precision: Liang & Zeger (1986), with Student's t for the number of blocks. Parameters at a bound
    reach away from it as far as with all of them free. For the others' intervals they are held there, but only where
    the least of the cost surely lies beyond. The rank of what the data say is that of H against the prior.
    """
    free, entries = fit.free, [fit.entries[i] for i in fit.free]
    slope = np.array([fit.p[i] if fit.entries[i].log else 1.0 for i in free])
    unit = np.array([entry.sd if np.isfinite(entry.sd) else 1.0 for entry in entries])
    precision = np.array([1.0 if np.isfinite(entry.sd) else 0.0 for entry in entries])
    scale = weights.scale
    columns = fit.jacobian * scale[..., None] * (slope * unit)
    residual = fit.residual * scale
    bounded, every = _at_bound(fit), np.arange(len(free))
    scores = np.zeros((int(block.max()) + 1, len(free)))
    np.add.at(scores, block, np.einsum("mn,mnf->mf", residual, columns))
    flat = columns.reshape(columns.shape[0] * columns.shape[1], -1)
    hessian = flat.T @ flat + np.diag(precision)
    push = scores.sum(axis=0) + _off_nominal(entries, fit.p[free])
    scores = margin * (scores - scores.mean(axis=0))
    meat = (scores.T @ scores) * len(scores) / max(len(scores) - 1, 1) + np.diag(precision)
    sure = float(stats.t.ppf(0.5 + level / 2, max(len(scores) - 1, 1)))
    gradient = np.zeros(len(free)) if pull is None else pull * slope * unit
    deviation, shift = _spread(hessian, meat, gradient, every)
    if bounded.any():
        beyond = np.abs(_spread(hessian, meat, push, every)[1]) > sure * deviation
        keep = np.flatnonzero(~(bounded & beyond))
        deviation[keep], shift[keep] = _spread(hessian, meat, gradient, keep)
    reach = sure * deviation
    down, up = reach + np.maximum(shift, 0.0), reach + np.maximum(-shift, 0.0)
    low, high = fit.p.copy(), fit.p.copy()
    low[free], high[free] = _ends(entries, fit.p[free], down, up, bounded)
    identified = np.zeros(len(fit.p), dtype=bool)
    identified[free] = (precision == 0.0) | (np.hypot(deviation, shift) < FLAT)
    return Intervals(low, high, identified)


def _spread(
    hessian: np.ndarray, meat: np.ndarray, gradient: np.ndarray, among: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the deviations of some parameters, the others held, and by how much a gradient shifts them."""
    size = np.sqrt(np.maximum(np.diag(hessian)[among], 1e-300))
    own, outer = np.ix_(among, among), np.outer(size, size)
    inverse = np.linalg.pinv(hessian[own] / outer, rcond=1e-12, hermitian=True)
    deviation = np.sqrt(np.maximum(np.diag(inverse @ (meat[own] / outer) @ inverse), 0.0)) / size
    return deviation, -inverse @ (gradient[among] / size) / size


def _off_nominal(entries: Sequence[Entry], p: np.ndarray) -> np.ndarray:
    """Return how far values are from the nominal ones, in standard deviations; 0 where they have no tolerance."""
    return np.array([(x - e.value) / e.sd if np.isfinite(e.sd) else 0.0 for e, x in zip(entries, p, strict=True)])


def _ends(
    entries: Sequence[Entry], p: np.ndarray, down: np.ndarray, up: np.ndarray, bounded: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the ends of intervals that reach so far down and up, in deviations or, of logarithms, in ratios.

    A decay constant is known by its ratio too, though it is fitted as it is: half of it is as far off as twice; but
    for one that is ``bounded``, which is next to nothing. Nothing lies beyond a physical bound.
    """
    low, high = p.copy(), p.copy()
    for i, entry in enumerate(entries):
        unit = entry.sd if np.isfinite(entry.sd) else 1.0
        if entry.log or (entry.name == DECAY and p[i] > 0.0 and not bounded[i]):
            size = 1.0 if entry.log else unit / p[i]
            ends = p[i] * np.exp(-down[i] * size), p[i] * np.exp(min(up[i] * size, MOST))
        else:
            ends = p[i] - down[i] * unit, p[i] + up[i] * unit
        low[i], high[i] = min(max(ends[0], entry.lower), p[i]), max(min(ends[1], entry.upper), p[i])
    return low, high


def _at_bound(fit: Fit) -> np.ndarray:
    """Return which free parameters rest on a physical bound."""
    out = []
    for i in fit.free:
        entry, value = fit.entries[i], fit.p[i]
        span = max(abs(value), abs(entry.value) if np.isfinite(entry.value) else 0.0, 1e-12)
        out.append(bool(value - entry.lower < 1e-6 * span or entry.upper - value < 1e-6 * span))
    return np.array(out, dtype=bool)
