"""Exact discretisation: what a zero-order hold, a lag and any delay do to a plant between two samples."""

from __future__ import annotations

import math

import control as ct
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

Floats = NDArray[np.float64]


def lagged(plant: ct.StateSpace, lags: Floats) -> ct.StateSpace:
    """Return the plant behind first-order lags (m,), s, one an input; 0 is none."""
    a, b, c = (np.asarray(part) for part in (plant.A, plant.B, plant.C))
    slow = [i for i, lag in enumerate(lags) if lag > 0.0]
    size, m = len(a), b.shape[1]
    wide_a, wide_b = np.zeros((size + len(slow),) * 2), np.zeros((size + len(slow), m))
    wide_a[:size, :size], wide_b[:size] = a, b
    for k, i in enumerate(slow):
        wide_a[:size, size + k], wide_b[:size, i] = b[:, i], 0.0
        wide_a[size + k, size + k], wide_b[size + k, i] = -1.0 / lags[i], 1.0 / lags[i]
    wide_c = np.hstack([c, np.zeros((len(c), len(slow)))])
    return ct.ss(wide_a, wide_b, wide_c, np.zeros((len(c), m)))


def sampled(plant: ct.StateSpace, sample_time: float, delays: Floats) -> ct.StateSpace:
    """Return a plant between samples under held, delayed inputs, exactly.

    Parameters
    ----------
    plant : control.StateSpace
        Continuous, without direct feedthrough.
    sample_time : float
        s.
    delays : array (m,)
        Of each input, s; any, whole samples or not. The past inputs that they need become states.

    Notes
    -----
    Åström & Wittenmark, "Computer-Controlled Systems" (1997), section 3.2.
    """
    a, b, c = (np.asarray(part) for part in (plant.A, plant.B, plant.C))
    size, m = b.shape
    whole = [math.floor(delay / sample_time + 1e-9) for delay in delays]
    rest = [max(delay - w * sample_time, 0.0) for delay, w in zip(delays, whole, strict=True)]
    depth = [w + (r > 1e-9 * sample_time) for w, r in zip(whole, rest, strict=True)]
    total = size + sum(depth)
    wide_a, wide_b = np.zeros((total, total)), np.zeros((total, m))
    wide_a[:size, :size] = expm(a * sample_time)
    first = size
    for i in range(m):
        late, early = _held(a, b[:, i], sample_time, rest[i])
        past = [first + k for k in range(depth[i])]  # newest first
        _enter(wide_a, wide_b, size, i, past, whole[i], late)
        if depth[i] > whole[i]:
            _enter(wide_a, wide_b, size, i, past, whole[i] + 1, early)
        for k, row in enumerate(past):
            if k == 0:
                wide_b[row, i] = 1.0
            else:
                wide_a[row, past[k - 1]] = 1.0
        first += depth[i]
    wide_c = np.hstack([c, np.zeros((len(c), total - size))])
    return ct.ss(wide_a, wide_b, wide_c, np.zeros((len(c), m)), sample_time)


def _enter(a: Floats, b: Floats, size: int, i: int, past: list[int], age: int, column: Floats) -> None:
    """Add the effect of input ``i`` as it was ``age`` samples ago."""
    if age == 0:
        b[:size, i] += column
    else:
        a[:size, past[age - 1]] += column


def _held(a: Floats, b: Floats, sample_time: float, rest: float) -> tuple[Floats, Floats]:
    """Return the effects of the input that holds from ``rest`` on, and of the one that holds until then."""
    late = _integral(a, b, sample_time - rest)
    early = expm(a * (sample_time - rest)) @ _integral(a, b, rest)
    return late, early


def _integral(a: Floats, b: Floats, span: float) -> Floats:
    """Return the integral of exp(A s) b over s from 0 to ``span`` (Van Loan 1978)."""
    size = len(a)
    block = np.zeros((size + 1, size + 1))
    block[:size, :size], block[:size, size] = a, b
    return np.asarray(expm(block * span)[:size, size], dtype=float)
