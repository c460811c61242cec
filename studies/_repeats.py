"""Repeated identification from readings drawn anew: errors and coverage, and the least error that any fit can have."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from _laws import curve_error
from _paper import READINGS, SCATTER, SPEEDS, TRIALS
from scipy.optimize import OptimizeWarning, curve_fit

from stribeck.identify.asymmetry import CLEAR, common_curve, compare_curves
from stribeck.identify.section3 import section3
from stribeck.identify.tustin_fit import CurveFit, curve_slopes, fit_curve, tustin

GRID = np.geomspace(SPEEDS[0], SPEEDS[-1], 200)
PLAIN_START = (1.0, 1.0, 1.0, 0.1)


@dataclass(frozen=True)
class Repeat:
    """What one draw gave: constants (4,) by each method, not a number where it failed; the fit with its intervals."""

    constants: dict[str, np.ndarray]
    section3_ok: bool
    fit: CurveFit


def draw(true: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return speeds and torques (P,) at the paper's conditions."""
    speed = np.concatenate([np.repeat(SPEEDS, TRIALS), np.zeros(READINGS)])
    return speed, tustin(true, speed) * (1.0 + SCATTER * rng.standard_normal(len(speed)))


def repeat(true: np.ndarray, rng: np.random.Generator) -> Repeat:
    """Identify from one draw by Section 3, by IPOPT, and by plain least squares from a careless start."""
    speed, torque = draw(true, rng)
    by_hand, fit = section3(speed, torque), fit_curve(speed, torque)
    return Repeat(
        {"section3": np.array(by_hand.constants), "ipopt": fit.constants, "least_squares": plain(speed, torque)},
        by_hand.ok,
        fit,
    )


def plain(speed: np.ndarray, torque: np.ndarray) -> np.ndarray:
    """Return the constants by `scipy.optimize.curve_fit`, unweighted; not a number where it gives up."""
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", OptimizeWarning)
        try:
            found, _ = curve_fit(
                lambda v, *c: tustin(np.array(c), v), speed, torque, PLAIN_START, bounds=(1e-6, np.inf)
            )
        except RuntimeError:
            return np.full(4, np.nan)
    return found


def errors(repeats: list[Repeat], true: np.ndarray, method: str) -> dict[str, object]:
    """Return the median relative error of each constant, and median and 95 % quantile of the curve's, of one method."""
    found = np.array([one.constants[method] for one in repeats])
    proper = np.isfinite(found).all(axis=1) & (found[:, 3] > 0.0)
    curve = np.array([curve_error(row, true, GRID) for row in found[proper]])
    return {
        "no_curve": int((~proper).sum()),
        "constants": np.median(np.abs(found[proper] / true - 1.0), axis=0).tolist(),
        **_spread(curve),
    }


def _spread(curve: np.ndarray) -> dict[str, object]:
    """Return what there is to say of curve errors (R,) over draws."""
    quantiles = {"median": float(np.median(curve)), "q95": float(np.quantile(curve, 0.95))}
    return {
        "curve": {**quantiles, "rms": float(np.sqrt(np.mean(curve**2))), "largest": float(curve.max())},
        "curve_within_2_percent": float(np.mean(curve <= 0.02)),
    }


def least_error(true: np.ndarray) -> dict[str, object]:
    """Return the curve errors of an unbiased fit that reaches the bound of Cramer and Rao on readings of one direction.

    The errors of its constants are normal with the inverse of Fisher's information, and small enough for the curve to
    be linear in them.
    """
    speed, _ = draw(true, np.random.default_rng(0))
    slopes = [curve_slopes(true, v) / tustin(true, v)[:, None] for v in (speed, GRID)]
    root = SCATTER * np.linalg.cholesky(np.linalg.inv(slopes[0].T @ slopes[0]))
    departures = np.random.default_rng(0).standard_normal((20_000, 4)) @ root.T @ slopes[1].T
    return _spread(np.sqrt(np.mean(departures**2, axis=1)))


def both_directions(true: np.ndarray, rng: np.random.Generator, repeats: int) -> dict[str, object]:
    """Return the curve errors of what `identify` takes where both directions were recorded and are alike."""

    def once() -> float:
        readings = [draw(true, rng), draw(true, rng)]
        apart = compare_curves(readings) < CLEAR
        fit = fit_curve(*readings[0]) if apart else common_curve(readings)
        return curve_error(fit.constants, true, GRID)

    return _spread(np.array([once() for _ in range(repeats)]))


def coverage(repeats: list[Repeat], true: np.ndarray) -> list[float]:
    """Return how many of the 95 % intervals hold the true value, for each constant (4)."""
    return np.mean([(one.fit.low <= true) & (true <= one.fit.high) for one in repeats], axis=0).tolist()
