"""Tustin's curve fitted to readings of friction with IPOPT, and intervals of its four constants.

The paper fitted by trial and error because the model is not linear in its constants. It is linear in three of the four:
for each alpha the best C0, C1, C2 follow from linear least squares, so that a search over one number finds where to
start (Golub & Pereyra 1973, variable projection), and IPOPT with exact derivatives does the rest.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy import stats
from scipy.optimize import nnls

from stribeck.identify.interrupts import held_back
from stribeck.identify.map_fit import GOOD

Floats = NDArray[np.float64]

NAMES = ("C0", "C1", "C2", "alpha")
LEAST_POINTS = 6
LEAST_SPEEDS = 4
APART = 1e-3  # relative: less is one speed
ALPHA_REACH = (0.2, 1.0)  # alpha lies between this share of the slowest velocity and this of the fastest
ALPHAS = 300  # trial values for the profiles
ENOUGH, ZOOMS = 30, 5  # of them within an interval, else they are drawn together around it, so often at most


@dataclass(frozen=True)
class CurveFit:
    """A fitted curve of one joint and direction.

    Attributes
    ----------
    constants, low, high : array (4,)
        C0, C1 (N m), C2 (N m s/rad), alpha (rad/s), and their 95 % intervals.
    identified : array (4,) of bool
        Which of them the readings bound on both sides.
    scatter : float
        Relative standard deviation of a reading about the curve.
    points : int
        Readings.
    chi2 : float
        Sum of squares of the relative residuals.
    covariance : array (4, 4)
        Of C0, C1, C2 and ln(alpha).
    status : str
        IPOPT's, or ``too_few_readings``.
    """

    constants: Floats
    low: Floats
    high: Floats
    identified: NDArray[np.bool_]
    scatter: float
    points: int
    chi2: float
    covariance: Floats
    status: str

    @property
    def ok(self) -> bool:
        """Whether the solver found a solution."""
        return self.status in GOOD

    def level(self, speed: Floats) -> Floats:
        """Return the friction (N m) at absolute velocities (V,), rad/s."""
        return tustin(self.constants, speed)

    def level_sd(self, speed: Floats) -> Floats:
        """Return the standard deviation of the fitted curve at absolute velocities (V,), N m."""
        slopes = curve_slopes(self.constants, np.asarray(speed, dtype=float))
        return np.asarray(np.sqrt(np.maximum(np.einsum("vi,ij,vj->v", slopes, self.covariance, slopes), 0.0)))


def tustin(constants: Floats, speed: Floats) -> Floats:
    """Return C0 + C1 exp(-v/alpha) + C2 v (N m), equation (1), at absolute velocities (V,), rad/s."""
    C0, C1, C2, alpha = constants
    return np.asarray(C0 + C1 * np.exp(-np.asarray(speed) / alpha) + C2 * np.asarray(speed))


def fit_curve(speed: Floats, torque: Floats) -> CurveFit:
    """Fit Tustin's curve to readings whose scatter is in proportion to the torque.

    Parameters
    ----------
    speed, torque : array (P,)
        Absolute velocity (rad/s; 0 is a break-away reading) and friction (N m) of every trial.

    Notes
    -----
    Residuals are relative to the fitted curve itself (two rounds), not to the readings: dividing by readings would
    favour those that came out low. Intervals are profiles of the sum of squares, with Student's t.
    """
    speed, torque = np.asarray(speed, dtype=float), np.asarray(torque, dtype=float)
    rising = np.sort(speed)
    speeds = 1 + np.sum(np.diff(rising) > APART * rising[1:])
    if len(speed) < LEAST_POINTS or speeds < LEAST_SPEEDS:
        return _none(len(speed), "too_few_readings")
    size = np.full(len(torque), float(np.mean(torque)))
    best, reach = _start(speed, torque, size)
    for _ in range(2):
        best, status = _solve(speed, torque, size, best, reach)
        size = tustin(best, speed)
    return _result(speed, torque, size, best, reach, status)


def _reach(speed: Floats) -> tuple[float, float]:
    moving = speed[speed > 0.0]
    return ALPHA_REACH[0] * float(moving.min()), ALPHA_REACH[1] * float(moving.max())


def _project(speed: Floats, torque: Floats, size: Floats, alpha: float) -> tuple[Floats, float]:
    """Return the best C0, C1, C2 for an alpha, none below 0, and the sum of squares."""
    design = np.stack([np.ones_like(speed), np.exp(-speed / alpha), speed], axis=1)
    linear, rest = nnls(design / size[:, None], torque / size)
    return linear, float(rest**2)


def _start(speed: Floats, torque: Floats, size: Floats) -> tuple[Floats, tuple[float, float]]:
    reach = _reach(speed)
    trials = [(_project(speed, torque, size, alpha), alpha) for alpha in np.geomspace(*reach, 40)]
    (linear, _), alpha = min(trials, key=lambda one: one[0][1])
    return np.append(linear, alpha), reach


@cache
def _solver(count: int) -> Any:
    """Return IPOPT for so many readings: z = (C0, C1, C2 over the mean torque, ln alpha)."""
    z, data = ca.SX.sym("z", 4), ca.SX.sym("data", count, 3)
    speed, torque, size = data[:, 0], data[:, 1], data[:, 2]
    curve = z[0] + z[1] * ca.exp(-speed / ca.exp(z[3])) + z[2] * speed
    cost = 0.5 * ca.sumsqr((torque - curve) / size)
    options = {
        "print_time": False,
        "ipopt": {"print_level": 0, "sb": "yes", "tol": 1e-10, "max_iter": 200, "bound_relax_factor": 0.0},
    }
    return ca.nlpsol("tustin", "ipopt", {"x": z, "p": ca.vec(data), "f": cost}, options)


def _solve(
    speed: Floats, torque: Floats, size: Floats, start: Floats, reach: tuple[float, float]
) -> tuple[Floats, str]:
    """Return the constants (4,) and IPOPT's status."""
    unit = float(np.mean(torque))
    data = np.stack([speed, torque / unit, size / unit], axis=1)
    z0 = np.append(start[:3] / unit, np.log(start[3]))
    solver = _solver(len(speed))
    low, high = [0.0, 0.0, 0.0, np.log(reach[0])], [np.inf, np.inf, np.inf, np.log(reach[1])]
    with held_back([]):
        solution = solver(x0=z0, p=data.T.ravel(), lbx=low, ubx=high)
    z = solution["x"].full().ravel()
    return np.append(z[:3] * unit, np.exp(z[3])), str(solver.stats()["return_status"])


def curve_slopes(constants: Floats, speed: Floats) -> Floats:
    """Return the derivatives (V, 4) of the curve by C0, C1, C2 and ln(alpha) at absolute velocities (V,), rad/s."""
    _, C1, _, alpha = constants
    decay = np.exp(-speed / alpha)
    return np.stack([np.ones_like(speed), decay, speed, C1 * decay * speed / alpha], axis=1)


def _result(
    speed: Floats, torque: Floats, size: Floats, best: Floats, reach: tuple[float, float], status: str
) -> CurveFit:
    residual = (torque - tustin(best, speed)) / size
    chi2, spare = float(residual @ residual), max(len(speed) - 4, 1)
    variance = chi2 / spare
    inside = [*(best[:3] > 1e-6 * best[:3].max()).tolist(), reach[0] * 1.001 < best[3] < reach[1] * 0.999]
    free = np.flatnonzero(inside)
    columns = curve_slopes(best, speed)[:, free] / size[:, None]
    covariance = np.zeros((4, 4))
    covariance[np.ix_(free, free)] = variance * np.linalg.pinv(columns.T @ columns)
    allowed = chi2 + variance * float(stats.t.ppf(0.975, spare)) ** 2
    low, high = _profiles(speed, torque, size, reach, allowed)
    low, high = np.minimum(low, best), np.maximum(high, best)
    bounded = np.append(low[:3] > 0.0, reach[0] * 1.001 < low[3] and high[3] < reach[1] * 0.999)
    identified = np.array(inside) & bounded
    return CurveFit(best, low, high, identified, float(np.sqrt(variance)), len(speed), chi2, covariance, status)


def _profiles(
    speed: Floats, torque: Floats, size: Floats, reach: tuple[float, float], allowed: float
) -> tuple[Floats, Floats]:
    """Return the ends (4,), (4,) of the set in which each constant's profile of the sum of squares is allowed.

    For one alpha the sum is a parabola in each linear constant, m + (c - c*)^2 / V, the other two at their best; the
    profile is the lowest of these parabolas, so that the set is the union of their intervals.
    """
    for _ in range(ZOOMS):
        alphas = np.geomspace(*reach, ALPHAS)
        linear, variance, chi2 = _projected(speed, torque, size, alphas)
        spare = allowed - chi2
        within = np.flatnonzero(spare >= 0.0)
        if len(within) >= ENOUGH:
            break
        around = within if len(within) else np.array([np.argmax(spare)])
        reach = alphas[max(around[0] - 1, 0)], alphas[min(around[-1] + 1, ALPHAS - 1)]
    if len(within) == 0:  # exact readings
        return np.full(4, np.inf), np.full(4, -np.inf)
    half = np.sqrt(variance[within] * spare[within, None])
    ends = [_crossing(alphas, spare, within[0], -1), _crossing(alphas, spare, within[-1], 1)]
    low = np.maximum(np.append((linear[within] - half).min(axis=0), ends[0]), 0.0)
    return low, np.append((linear[within] + half).max(axis=0), ends[1])


def _projected(speed: Floats, torque: Floats, size: Floats, alphas: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the best C0, C1, C2 (A, 3) for each alpha, of either sign, what V is of each, and the sums of squares."""
    decay = np.exp(-speed / alphas[:, None])
    design = np.stack(np.broadcast_arrays(1.0, decay, speed), axis=2) / size[:, None]  # (A, P, 3)
    weighted = torque / size
    inverse = np.linalg.pinv(design.transpose(0, 2, 1) @ design, hermitian=True)
    linear = np.einsum("aij,apj,p->ai", inverse, design, weighted)
    chi2 = np.sum((weighted - np.einsum("apj,aj->ap", design, linear)) ** 2, axis=1)
    return linear, np.einsum("aii->ai", inverse), chi2


def _crossing(alphas: Floats, spare: Floats, k: int, side: int) -> float:
    """Return the alpha beyond the k-th at which what is spare runs out; the end of the reach where it does not."""
    if not 0 <= k + side < len(alphas):
        return float(alphas[k])
    share = spare[k] / (spare[k] - spare[k + side])
    return float(alphas[k] * (alphas[k + side] / alphas[k]) ** share)


def _none(points: int, status: str) -> CurveFit:
    nothing = np.full(4, np.nan)
    return CurveFit(
        nothing, nothing, nothing, np.zeros(4, dtype=bool), np.nan, points, np.nan, np.full((4, 4), np.nan), status
    )
