"""Describing function of Tustin friction, in closed form."""

from __future__ import annotations

import math
from functools import cache

import control as ct
import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaln

from stribeck.arm.values import Friction

Floats = NDArray[np.float64]

POWERS_UP_TO, SERIES_FROM = 8.0, 40.0
NODES, TERMS, POWERS = 80, 10, 56


class TustinFriction(ct.DescribingFunctionNonlinearity):  # type: ignore[misc]
    """Tustin friction as a nonlinearity for python-control, with its describing function in closed form.

    Parameters
    ----------
    friction : Friction
        C0, C1 (N m), C2 (N m s/rad) and alpha (rad/s); for an asymmetric joint, take `symmetric`.
    """

    def __init__(self, friction: Friction) -> None:
        super().__init__()
        self.friction = friction

    def __call__(self, velocity: float) -> float:
        """Return the friction torque (N m) at a velocity (rad/s); 0 at 0, where it is a set."""
        f, v = self.friction, float(np.squeeze(velocity))
        return math.copysign(f.C0 + f.C1 * math.exp(-abs(v) / f.alpha) + f.C2 * abs(v), v) if v != 0.0 else 0.0

    def describing_function(self, A: float) -> float:
        """Return N (N m s/rad) at a velocity amplitude (rad/s)."""
        return float(describing_function(np.array(float(A)), self.friction))

    def _isstatic(self) -> bool:
        return True


def describing_function(amplitude: Floats, friction: Friction) -> Floats:
    """Return N(V) = 4 C0/(pi V) + (2 C1/V) [2/pi + L1(V/alpha) - I1(V/alpha)] + C2, N m s/rad.

    L1 is the modified Struve and I1 the modified Bessel function.

    Parameters
    ----------
    amplitude : array
        V > 0 of the velocity, rad/s.
    friction : Friction

    Notes
    -----
    From the first Fourier coefficient, with the integral of exp(-x sin t) sin t over half a period written by DLMF
    11.5.4 as pi [2/pi + L1(x) - I1(x)].
    """
    v = np.asarray(amplitude, dtype=float)
    fading = exponential_part(v / friction.alpha) if friction.C1 != 0.0 else 0.0
    return np.asarray(4.0 * friction.C0 / (math.pi * v) + 2.0 * friction.C1 / (math.pi * v) * fading + friction.C2)


def exponential_part(x: Floats) -> Floats:
    """Return pi [2/pi + L1(x) - I1(x)], the integral of exp(-x sin t) sin t over t from 0 to pi, for x >= 0.

    Notes
    -----
    L1 and I1 grow as exp(x) while their difference falls as 1/x^2: from x = 8 on the two cancel to worse than 1e-11, at
    20 to 1e-6. Up to 8 their power series (DLMF 10.25.2 and 11.2.2) are summed as one, in a hundredth of the time of
    the functions themselves. Beyond 40 the asymptotic series (DLMF 11.6.2) is exact to rounding; between the two
    Gauss's quadrature of the integral itself is, its integrand being smooth there.
    """
    x = np.asarray(x, dtype=float)
    flat = np.atleast_1d(x).ravel()
    value = np.empty_like(flat)
    small, large = flat <= POWERS_UP_TO, flat >= SERIES_FROM
    for chosen, law in ((small, _powers), (large, _series), (~(small | large), _quadrature)):
        if chosen.any():
            value[chosen] = law(flat[chosen])
    return value.reshape(x.shape)


def _powers(x: Floats) -> Floats:
    """Return the sum over n of (-x)^n/n! times the integral of sin^(n+1) t over t from 0 to pi."""
    total = np.zeros_like(x)
    for factor in _factors()[::-1]:
        total = total * x + factor
    return total


@cache
def _factors() -> tuple[float, ...]:
    n = np.arange(POWERS)
    integral = 0.5 * math.log(math.pi) + gammaln(0.5 * n + 1.0) - gammaln(0.5 * n + 1.5)
    return tuple(((-1.0) ** n * np.exp(integral - gammaln(n + 1.0))).tolist())


def _series(x: Floats) -> Floats:
    """Return the asymptotic series 2/x^2 (1 + 3/x^2 + 45/x^4 + ...)."""
    term = 2.0 / x**2
    total = np.zeros_like(x)
    for k in range(TERMS):
        total = total + term
        term = term * (2 * k + 1) * (2 * k + 3) / x**2
    return total


def _quadrature(x: Floats) -> Floats:
    angle, weight = nodes(NODES)
    sine = np.sin(0.5 * math.pi * angle)
    return np.asarray(math.pi * np.exp(-x[..., None] * sine) @ (weight * sine))


@cache
def nodes(count: int) -> tuple[Floats, Floats]:
    """Return Gauss-Legendre nodes and weights on 0 to 1."""
    x, w = np.polynomial.legendre.leggauss(count)
    return 0.5 * (x + 1.0), 0.5 * w


def symmetric(forward: Friction, backward: Friction) -> Friction:
    """Return the constants whose describing function is that of an asymmetric joint, but for its constant torque.

    The decay constant is that of the side with more fading torque: the two are one where alpha is the same.
    """
    alpha = forward.alpha if forward.C1 >= backward.C1 else backward.alpha
    c0, c1, c2 = (0.5 * (getattr(forward, key) + getattr(backward, key)) for key in ("C0", "C1", "C2"))
    return Friction(c0, c1, c2, alpha)
