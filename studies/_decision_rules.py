"""Rules of decision, each a pure function of one case's fits: how strongly each rival shows, and which to name.

A domain is the residual that a rule looks at: ``torque`` along the recorded motion, ``motion`` (windows of forward
simulation), or ``both``, where a joint's motion counts as a further channel of equal right.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import minimize
from scipy.special import gammaln, logsumexp
from scipy.stats import chi2

from stribeck.gap.records.blocks import t_value
from stribeck.gap.search.rank import log_ratio

DECISIVE = 6.0  # difference of BIC (Kass & Raftery 1995: strong)
SURE_T = 2.8  # block t value of a held-out gain
RARE = float(-np.log(0.05))  # -log of a test's level
FAR = 500.0  # chi-square statistic from which its tail is taken from the series
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


@dataclass(frozen=True)
class Evidence:
    """How strongly a rule holds each rival to be there, and which one it prefers among those above its threshold.

    ``strength`` and ``preference`` are (K - 1,), a rival each.
    """

    strength: np.ndarray
    preference: np.ndarray

    def named(self, threshold: float) -> int:
        """Return which rival (from 1) is named, or 0 for none."""
        sure = np.flatnonzero(self.strength > threshold)
        return int(sure[np.argmax(self.preference[sure])]) + 1 if len(sure) else 0


def bic(fits: Mapping[str, Any], domain: str) -> Evidence:
    """Return how far the BIC of each lies below that of no effect (Schwarz 1978)."""
    s = seen(fits, domain)
    value = -2.0 * log_likelihood(s) + s.own * np.log(s.rows)
    return Evidence(value[0] - value[1:], -value[1:])


def likelihood_ratio(fits: Mapping[str, Any], domain: str) -> Evidence:
    """Return -log p of the likelihood ratio by chi-square, as for white noise (Wilks 1938)."""
    s = seen(fits, domain)
    value = log_likelihood(s)
    rare = rarity(2.0 * np.maximum(value[1:] - value[0], 0.0), s.own[1:])
    return Evidence(rare, rare)


def rarity(statistic: np.ndarray, degrees: np.ndarray) -> np.ndarray:
    """Return -log p of chi-square statistics, however small p: what underflows could not be told apart.

    Beyond FAR the first two terms of the asymptotic series are exact to 1e-4 (Abramowitz & Stegun 1964, 26.4.11).
    """
    half, a = 0.5 * np.maximum(statistic, FAR), 0.5 * degrees
    tail = half - (a - 1.0) * np.log(half) + gammaln(a) - np.log1p((a - 1.0) / half)
    return np.asarray(np.where(statistic > FAR, tail, -chi2.logsf(np.minimum(statistic, FAR), degrees)))


def block_score(fits: Mapping[str, Any], domain: str) -> Evidence:
    """Return -log p of the block-robust score test, the level shared by all candidates (Bonferroni)."""
    if domain != "torque":
        raise ValueError("simulated motion has no score: the path through sticking is not smooth")
    statistic, degrees = np.array(fits["score"], dtype=float).T
    rare = rarity(statistic, np.maximum(degrees, 1.0)) - np.log(fits["candidates"])
    return Evidence(rare, rare)


def held_out(fits: Mapping[str, Any], domain: str) -> Evidence:
    """Return the t value over blocks of each gain on held-out runs; the largest gain is preferred."""
    squares = seen(fits, domain).held
    best = np.min(squares.mean(axis=1), axis=0)
    loss = squares / np.maximum(best, 1e-300)
    t = np.array([t_value(log_ratio(loss[0], row)) for row in loss[1:]])
    total = np.sum(np.log(squares.sum(axis=1) + 1e-300), axis=1)
    return Evidence(np.where(total[1:] < total[0], t, -np.inf), -total[1:])


def stacked(fits: Mapping[str, Any], domain: str) -> Evidence:
    """Return the weights with which predictive densities of held-out blocks are stacked (Yao et al. 2018)."""
    s = seen(fits, domain)
    variance = (s.fit.sum(axis=1) / s.rows)[:, None, :] + 1e-300
    per_row = np.log(variance) + s.held / (s.held_rows[None, :, None] * variance)
    density = -0.5 * np.sum(s.held_rows[None, :, None] / s.correlation * per_row, axis=2)  # (K, B)
    weights = stacking_weights(density)[1:]
    return Evidence(weights, weights)


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


@dataclass(frozen=True)
class Rule:
    """A rule with its usual threshold, and the thresholds (T,) that are tried in hindsight, least strict first."""

    weigh: Callable[[Mapping[str, Any], str], Evidence]
    usual: float
    others: np.ndarray

    def __call__(self, fits: Mapping[str, Any], domain: str) -> int:
        """Return which rival is named at the usual threshold, or 0."""
        return self.weigh(fits, domain).named(self.usual)


RULES: Mapping[str, Rule] = {
    "BIC": Rule(bic, DECISIVE, np.geomspace(1.0, 1e5, 51)),
    "likelihood ratio": Rule(likelihood_ratio, RARE, np.geomspace(1.0, 1e5, 51)),
    "block score": Rule(block_score, RARE, np.geomspace(0.1, 1e4, 51)),
    "held-out gain": Rule(held_out, SURE_T, np.linspace(0.0, 20.0, 41)),
    "stacking": Rule(stacked, MOST, np.linspace(0.0, 0.98, 50)),
}
DOMAINS = ("torque", "motion", "both")
