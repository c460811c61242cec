"""Rules of decision, each a pure function of one case's fits: which rival to name, or 0 for none.

A domain is the residual that a rule looks at: ``torque`` along the recorded motion, ``motion`` (windows of forward
simulation), or ``both``, where a joint's motion counts as a further channel of equal right.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import minimize
from scipy.special import logsumexp
from scipy.stats import chi2

from stribeck.gap.blocks import t_value
from stribeck.gap.rank import log_ratio

DECISIVE = 6.0  # difference of BIC (Kass & Raftery 1995: strong)
SURE_T = 2.8  # block t value of a held-out gain
LEVEL = 0.05  # of tests
MOST = 0.5  # of the weight: from here on a stacked model is named


@dataclass(frozen=True)
class Seen:
    """One domain's residuals of K models, the first without an effect, in n channels.

    ``fit`` and ``held`` are squares summed over blocks (K, B, n) of the fitted and the held-out runs; ``rows`` counts
    the fitted rows, ``held_rows`` (B,) those of each held-out block; ``correlation`` (n,) of them count as one;
    ``prior`` (K,) is the prior's cost, ``own`` (K,) the number of an effect's parameters.
    """

    fit: np.ndarray
    held: np.ndarray
    rows: int
    held_rows: np.ndarray
    correlation: np.ndarray
    prior: np.ndarray
    own: np.ndarray


def seen(fits: Mapping[str, Any], domain: str) -> Seen:
    """Return what a case's fits (``_decision_fits.fits_of_a_case``) show in a domain."""
    parts = ("torque", "motion") if domain == "both" else (domain,)

    def joined(which: str, suffix: str = "") -> np.ndarray:
        return np.concatenate([np.array(fits[which][part + suffix], dtype=float) for part in parts], axis=-1)

    return Seen(
        joined("fit"), joined("held"), int(np.sum(fits["fit"]["rows"])), np.array(fits["held"]["rows"], dtype=float),
        joined("fit", "_correlation").min(axis=0), np.array(fits["prior"]), np.array(fits["own"]),
    )  # fmt: skip


def log_likelihood(s: Seen) -> np.ndarray:
    """Return the concentrated log likelihood (K,) on the fitted runs, every row taken for independent."""
    return np.asarray(-0.5 * s.rows * np.sum(np.log(s.fit.sum(axis=1) + 1e-300), axis=1) - s.prior)


def bic(fits: Mapping[str, Any], domain: str) -> int:
    """Name the smallest BIC where it lies DECISIVE below that of no effect (Schwarz 1978)."""
    s = seen(fits, domain)
    value = -2.0 * log_likelihood(s) + s.own * np.log(s.rows)
    best = int(np.argmin(value))
    return best if value[best] < value[0] - DECISIVE else 0


def likelihood_ratio(fits: Mapping[str, Any], domain: str) -> int:
    """Name the most significant rival where chi-square says so at LEVEL, as for white noise (Wilks 1938)."""
    s = seen(fits, domain)
    value = log_likelihood(s)
    return _surest(chi2.logsf(2.0 * np.maximum(value[1:] - value[0], 0.0), s.own[1:]), LEVEL)


def block_score(fits: Mapping[str, Any], domain: str) -> int:
    """Name the most significant rival by the block-robust score test, LEVEL shared by all candidates (Bonferroni)."""
    if domain != "torque":
        raise ValueError("simulated motion has no score: the path through sticking is not smooth")
    statistic, degrees = np.array(fits["score"], dtype=float).T
    return _surest(chi2.logsf(statistic, np.maximum(degrees, 1.0)), LEVEL / fits["candidates"])


def _surest(log_p: np.ndarray, level: float) -> int:
    best = int(np.argmin(log_p))
    return best + 1 if log_p[best] < np.log(level) else 0


def held_out(fits: Mapping[str, Any], domain: str) -> int:
    """Name the largest gain on held-out runs among those whose t value over blocks is SURE_T at least."""
    squares = seen(fits, domain).held
    best = np.min(squares.mean(axis=1), axis=0)
    loss = squares / np.maximum(best, 1e-300)
    t = np.array([t_value(log_ratio(loss[0], row)) for row in loss])
    total = np.sum(np.log(squares.sum(axis=1) + 1e-300), axis=1)
    sure = [k for k in range(1, len(t)) if t[k] > SURE_T and total[k] < total[0]]
    return min(sure, key=lambda k: float(total[k]), default=0)


def stacked(fits: Mapping[str, Any], domain: str) -> int:
    """Name what gets most of the weight when predictive densities of held-out blocks are stacked (Yao et al. 2018)."""
    s = seen(fits, domain)
    variance = (s.fit.sum(axis=1) / s.rows)[:, None, :] + 1e-300
    per_row = np.log(variance) + s.held / (s.held_rows[None, :, None] * variance)
    density = -0.5 * np.sum(s.held_rows[None, :, None] / s.correlation * per_row, axis=2)  # (K, B)
    weights = stacking_weights(density)
    best = int(np.argmax(weights))
    return best if weights[best] > MOST else 0


def stacking_weights(density: np.ndarray) -> np.ndarray:
    """Return the weights (K,) of the mixture under which log densities (K, B) of blocks are likeliest."""

    def cost(z: np.ndarray) -> tuple[float, np.ndarray]:
        log_w = z - logsumexp(z)
        mixed = logsumexp(density + log_w[:, None], axis=0)
        share = np.exp(density + log_w[:, None] - mixed).mean(axis=1)
        return float(-mixed.mean()), np.exp(log_w) - share

    found = minimize(cost, np.zeros(len(density)), jac=True, method="L-BFGS-B", bounds=[(-30.0, 30.0)] * len(density))
    return np.asarray(np.exp(found.x - logsumexp(found.x)))


def gains_in_motion(fits: Mapping[str, Any], k: int) -> bool:
    """Return whether the k-th model simulates the held-out runs better than the model without an effect."""
    total = np.sum(np.log(seen(fits, "motion").held.sum(axis=1) + 1e-300), axis=1)
    return bool(total[k] < total[0])


Rule = Callable[[Mapping[str, Any], str], int]
RULES: Mapping[str, Rule] = {
    "BIC": bic,
    "likelihood ratio": likelihood_ratio,
    "block score": block_score,
    "held-out gain": held_out,
    "stacking": stacked,
}
DOMAINS = ("torque", "motion", "both")
