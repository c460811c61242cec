"""Section 3.3: alpha from the saddle point, equations (3) and (10) to (12), and what goes wrong with it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import lambertw

from stribeck.identify.section3.readings import Readings


@dataclass(frozen=True)
class Saddle:
    """The lowest reading: ``velocity`` (rad/s), ``torque`` (N m), and whether slower readings lie above it."""

    velocity: float
    torque: float
    bent: bool


def lowest_reading(readings: Readings) -> Saddle | None:
    """Return the reading of least torque (steps 1 and 2); None where there is none."""
    if len(readings.speed) == 0:
        return None
    k = int(np.argmin(readings.torque))
    return Saddle(float(readings.speed[k]), float(readings.torque[k]), k > 0)


def alpha_at(saddle: Saddle, C0: float, C2: float) -> float:
    """Return alpha (rad/s) by equation (12), (tau* - C0 - C2 |dq*|) / C2; not a number without viscous friction."""
    return (saddle.torque - C0 - C2 * saddle.velocity) / C2 if C2 != 0.0 else np.nan


def alphas_by_velocity(velocity: float, C1: float, C2: float) -> tuple[float, ...]:
    """Return every alpha (rad/s) whose saddle point (3) lies at a velocity: two, one or none, rising.

    Notes
    -----
    With u = ln(C1/(C2 alpha)), equation (3) reads u e^-u = C2 dq*/C1, so that u = -W(-C2 dq*/C1) on the two real
    branches of Lambert's function. The paper says that there can be infinitely many solutions; there are at most two,
    and none where dq* exceeds C1/(e C2).
    """
    if not (C1 > 0.0 and C2 > 0.0 and velocity > 0.0):
        return ()
    x = C2 * velocity / C1
    if x > np.exp(-1.0):
        return ()
    u = [-float(lambertw(-x, branch).real) for branch in (-1, 0)]
    found = sorted({C1 / C2 * float(np.exp(-value)) for value in u})
    return tuple(found)


def amplification(saddle: Saddle, C2: float, alpha: float) -> float:
    """Return by how much equation (12) blows up a relative error of the torque at the saddle: tau* / (C2 alpha)."""
    return abs(saddle.torque / (C2 * alpha)) if C2 * alpha != 0.0 else np.inf
