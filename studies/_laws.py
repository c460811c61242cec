"""Closed forms that the studies hold the paper's claims against."""

from __future__ import annotations

import numpy as np

from stribeck.identify.tustin_fit import tustin


def curve_error(found: np.ndarray, true: np.ndarray, speed: np.ndarray) -> float:
    """Return the relative rms difference of two curves (constants (4,)) over speeds (V,); not a number without both."""
    return float(np.sqrt(np.mean((tustin(np.asarray(found), speed) / tustin(true, speed) - 1.0) ** 2)))


def least_viscous(saddle: float, speed: float = 0.03, rest: float = 6.25, there: float = 6.5) -> float:
    """Return the least C2 (N m s/rad) with C0 + C1 = rest, F(speed) = there and the saddle (3) at a velocity (rad/s).

    By (10), C1 = C2 alpha exp(saddle/alpha), so that both conditions give C2 for each alpha.
    """
    alpha = saddle * np.geomspace(0.05, 20.0, 4000)
    drop = alpha * np.exp(saddle / alpha) * -np.expm1(-speed / alpha)
    possible = speed > drop
    return float(((there - rest) / (speed - drop[possible])).min())


def stick_slip_velocity(constants: np.ndarray, kv: float) -> float:
    """Return the velocity (rad/s) below which Kv + F'(v) < 0, so that steady sliding is unstable; 0 where none is."""
    _, C1, C2, alpha = constants
    return max(0.0, float(alpha * np.log(C1 / (alpha * (C2 + kv)))))
