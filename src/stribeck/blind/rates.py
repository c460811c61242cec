"""Shares with their uncertainty, calibration, and the strength at which an effect is found."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from scipy.optimize import minimize
from scipy.stats import binomtest

BINS = 10
DRAWS = 500
SLOPE = (1.5, 1.0)  # prior of the logarithm of the steepness of a detection curve: mean, standard deviation


def rate(hits: Iterable[bool]) -> dict[str, Any]:
    """Return ``k`` of ``n``, the share ``value`` and its 95 % interval (Wilson 1927); null without cases."""
    given = list(hits)
    k, n = sum(map(bool, given)), len(given)
    if n == 0:
        return {"k": 0, "n": 0, "value": None, "ci95": None}
    between = binomtest(k, n).proportion_ci(confidence_level=0.95, method="wilson")
    return {"k": k, "n": n, "value": _short(k / n), "ci95": [_short(between.low), _short(between.high)]}


def calibration(statements: Sequence[tuple[float, bool]], seed: int = 0) -> dict[str, Any]:
    """Return reliability of stated probabilities: bins of equal width and the expected calibration error.

    Parameters
    ----------
    statements : sequence of (float, bool)
        Probability that was stated, and whether it was so.
    seed : int
        Of the bootstrap of the error.

    Returns
    -------
    dict
        ``n``, ``ece`` with ``ci95`` (bootstrap over statements), ``bins``: mean ``stated`` against the rate that held.
        The error is the mean over bins of |stated - held|, weighted by their statements (Guo et al. 2017); it is
        above 0 by chance alone, by ``ece_by_chance`` on average, where every probability holds.
    """
    if not statements:
        return {"n": 0, "ece": None, "ci95": None, "ece_by_chance": None, "bins": []}
    p = np.array([stated for stated, _ in statements], dtype=float)
    held = np.array([was for _, was in statements], dtype=float)
    place = np.minimum((p * BINS).astype(int), BINS - 1)
    rng = np.random.default_rng(seed)
    picks = rng.integers(len(p), size=(DRAWS, len(p)))
    spread = [_ece(p[i], held[i], place[i]) for i in picks]
    chance = [_ece(p, rng.random(len(p)) < p, place) for _ in range(DRAWS)]
    bins = [
        {"stated": _short(float(p[place == b].mean())), "held": rate(held[place == b] > 0.5)}
        for b in range(BINS)
        if np.any(place == b)
    ]
    return {
        "n": len(p),
        "ece": _short(_ece(p, held, place)),
        "ci95": [_short(float(np.quantile(spread, q))) for q in (0.025, 0.975)],
        "ece_by_chance": _short(float(np.mean(chance))),
        "bins": bins,
    }


def _ece(p: np.ndarray, held: np.ndarray, place: np.ndarray) -> float:
    gap = np.bincount(place, p - held, BINS)
    return float(np.abs(gap).sum() / len(p))


def detection_limit(strengths: Sequence[float], found: Sequence[bool], seed: int = 0) -> dict[str, Any] | None:
    """Return the strength at which an effect is named half of the time, by logistic regression on its logarithm.

    Parameters
    ----------
    strengths : sequence of float
        Effect torque over noise floor, of each case. One of strength 0 shows elsewhere, if at all, and says nothing of
        a limit: it is left out.
    found : sequence of bool
        Whether it was named.
    seed : int
        Of the bootstrap.

    Returns
    -------
    dict or None
        ``strength`` with ``ci95`` (bootstrap over cases); ``outside`` is ``"below"`` or ``"above"`` where the limit
        lies beyond the strengths that were tried, and the number is then the nearest one tried. None with fewer than
        four cases.
    """
    strength = np.asarray(strengths, dtype=float)
    x = np.log(np.maximum(strength[strength > 0.0], 1e-3))
    y = np.asarray(found, dtype=float)[strength > 0.0]
    if len(x) < 4:
        return None
    rng = np.random.default_rng(seed)
    low, high = float(x.min()), float(x.max())
    value = _half(x, y)
    drawn = [_half(x[i], y[i]) for i in rng.integers(len(x), size=(100, len(x)))]
    outside = "below" if value < low else "above" if value > high else None
    near = [float(np.clip(v, low, high)) for v in (value, np.quantile(drawn, 0.025), np.quantile(drawn, 0.975))]
    limit, *ends = (_short(math.exp(v)) for v in near)
    return {"strength": limit, "ci95": ends, "outside": outside, "n": len(x)}


def _half(x: np.ndarray, y: np.ndarray) -> float:
    """Return the logarithm of the strength at which half are found; steepness and place have weak priors."""
    middle = float(np.mean(x))

    def cost(theta: np.ndarray) -> float:
        z = np.exp(theta[1]) * (x - theta[0])
        misfit = float(np.sum(np.logaddexp(0.0, z) - y * z))
        prior = ((theta[1] - SLOPE[0]) / SLOPE[1]) ** 2 + ((theta[0] - middle) / 3.0) ** 2
        return misfit + 0.5 * float(prior)

    fits = [minimize(cost, (start, 1.0), method="Nelder-Mead") for start in (middle - 1.0, middle + 1.0)]
    return float(min(fits, key=lambda fit: float(fit.fun)).x[0])


def _short(value: float) -> float:
    return float(f"{value:.4g}")
