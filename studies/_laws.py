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


def coth_amplitude(ratio: float, zeta: float, kp: float, coulomb: float) -> float:
    """Return the amplitude (rad) of the cycle that over-compensated Coulomb friction on measured velocity makes."""
    return float((ratio - 1.0) * coulomb / kp / np.tanh(np.pi * zeta / (2.0 * np.sqrt(1.0 - zeta**2))))


def largest_gain(delay: int, sample: float = 0.0125, inertia: float = 1.0) -> float:
    """Return the largest Kp (N m/rad) of a sampled PD that is stable, Kv = 2 sqrt(Kp J), velocity by finite difference.

    The eigenvalues of the sampled double integrator with the PD and so many whole samples of delay, by bisection.
    """

    def stable(kp: float) -> bool:
        kv = 2.0 * np.sqrt(kp * inertia)
        size = 3 + delay  # position, velocity, the position before, and the commands under way
        a = np.zeros((size, size))
        law = np.zeros(size)
        law[0], law[2] = -kp - kv / sample, kv / sample
        acting = np.eye(size)[2 + delay] if delay else law
        a[0] = np.eye(size)[0] + sample * np.eye(size)[1] + 0.5 * sample**2 / inertia * acting
        a[1] = np.eye(size)[1] + sample / inertia * acting
        a[2] = np.eye(size)[0]
        if delay:
            a[3] = law
            for k in range(1, delay):
                a[3 + k] = np.eye(size)[2 + k]
        return float(np.abs(np.linalg.eigvals(a)).max()) < 1.0

    low, high = 1.0, 1e5
    while high / low > 1.0001:
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if stable(middle) else (low, middle)
    return low
