"""Where a periodic law may start: the strongest waves that a residual holds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import welch

FINENESS = 1.0  # rad of phase, over the whole span, between neighbouring rates
ROWS = 4000  # samples that are looked at, at most
MOST = 8000  # rates
SHOWN = 0.45  # of the rate of samples, up to which they show a tone and not its alias
TOGETHER = 100  # rates at a time: bounds the memory
GOLDEN = 0.5 * (5.0**0.5 - 1.0)
WINDOW, PADDED = 4.0, 4096  # s of one periodogram, and its length with zeros


@dataclass(frozen=True)
class Reach:
    """What a chain of n joints did at the samples of a trace.

    Attributes
    ----------
    levers : array (M, n, 2)
        Vectors from the joints to the tip in the base frame, m: the first is where the tip is.
    velocity, residual : array (M, n)
        Of all joints, rad/s and N m.
    """

    levers: np.ndarray
    velocity: np.ndarray
    residual: np.ndarray


@dataclass(frozen=True)
class Trace:
    """What one joint did in the fitted runs, one after the other, at the analysis samples; each (M,), SI.

    ``residual`` is that of the model so far, in N m of command; ``starts`` the first rows of the second run and on;
    ``reach`` tells of the whole chain, where there is one.
    """

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    command: np.ndarray
    residual: np.ndarray
    starts: tuple[int, ...] = ()
    reach: Reach | None = None


@dataclass(frozen=True)
class Wave:
    """A wave sine * sin(rate x) + cosine * cos(rate x)."""

    rate: float
    sine: float
    cosine: float


def strongest_waves(
    x: np.ndarray, carrier: np.ndarray, trace: Trace, rates: tuple[float, float], count: int = 3
) -> list[Wave]:
    """Return the waves over ``x``, times ``carrier``, that take most of a residual, strongest first.

    Parameters
    ----------
    x, carrier : array (M,)
        What the wave runs over, and what its amplitude is in proportion to.
    trace : Trace
    rates : (float, float)
        Range of the rates, radians per unit of ``x``.
    count : int
        Peaks at most; at least one wave is returned.

    Notes
    -----
    Least squares at each rate of a grid so fine that no rate lies far, over the span of ``x``, from its neighbour
    (Lomb 1976).
    """
    rows = _some(len(x))
    x, carrier, r = x[rows], carrier[rows], trace.residual[rows]
    number = int(np.clip((rates[1] - rates[0]) * float(np.ptp(x)) / FINENESS, 2, MOST))
    grid = np.linspace(*rates, number)
    turns = np.exp(1j * np.outer(np.arange(min(number, TOGETHER)) * (grid[1] - grid[0]), x))  # within a part: the same
    parts = []
    for i in range(0, number, TOGETHER):
        some = grid[i : i + TOGETHER]
        parts.append(_fit(turns[: len(some)] * np.exp(1j * grid[i] * x), carrier, r))
    saved, sine, cosine = np.concatenate(parts, axis=1)
    left, right = np.concatenate([[-1.0], saved[:-1]]), np.concatenate([saved[1:], [-1.0]])
    peaks = np.flatnonzero((saved >= left) & (saved >= right))
    best = peaks[np.argsort(-saved[peaks])][:count]
    return [Wave(float(grid[i]), float(sine[i]), float(cosine[i])) for i in best]


def tones(trace: Trace, band: tuple[float, float], count: int) -> list[Wave]:
    """Return the waves over time that take most of a residual, strongest first; their rates in Hz.

    Analysis samples are few where encoders are coarse: beyond half their rate each tone has an alias as strong.
    """
    turns, step = 2.0 * np.pi * trace.time, float(np.median(np.abs(np.diff(trace.time))))
    top = min(band[1], max(SHOWN / step, 2.0 * band[0]))
    return strongest_waves(turns, np.ones_like(turns), trace, (band[0], top), count)


def _some(rows: int) -> np.ndarray:
    """Return what is looked at of so many rows: of each stretch one, never at equal distances, which have aliases."""
    stretch = max(1, rows // ROWS)
    first = np.arange(0, rows - stretch + 1, stretch)
    return np.asarray(first + (stretch * (GOLDEN * np.arange(len(first)) % 1.0)).astype(int))


def ringing(trace: Trace, frequencies: tuple[float, float], count: int = 2) -> list[float]:
    """Return the frequencies (Hz) at which a residual is loudest whatever its phase, loudest first.

    What rings on its own spring does so from every shock anew. Periodograms of a few seconds, averaged over all runs
    (Welch 1967).
    """
    hertz, power = np.zeros(PADDED // 2 + 1), np.zeros(PADDED // 2 + 1)
    for time, part in zip(*(np.split(signal, trace.starts) for signal in (trace.time, trace.residual)), strict=True):
        if len(part) < 8 or time[-1] <= time[0]:
            continue
        step = float(time[-1] - time[0]) / (len(time) - 1)
        rows = min(len(part), max(int(WINDOW / step), 8), PADDED)
        own, density = welch(part, 1.0 / step, nperseg=rows, nfft=PADDED)
        hertz = hertz if hertz.any() else own
        power += len(part) * np.interp(hertz, own, density, right=0.0)
    inside = (power[1:-1] >= power[:-2]) & (power[1:-1] >= power[2:]) & (power[1:-1] > 0.0)
    peaks = np.flatnonzero(inside) + 1
    peaks = peaks[(hertz[peaks] >= frequencies[0]) & (hertz[peaks] <= frequencies[1])]
    return [float(hertz[i]) for i in peaks[np.argsort(-power[peaks])][:count]]


def _fit(wave: np.ndarray, carrier: np.ndarray, r: np.ndarray) -> np.ndarray:
    """Return the squares saved and both amplitudes, (3, G), at each of G rates; ``wave`` (G, M) is exp(i rate x)."""
    total, turned = float(carrier @ carrier), wave**2 @ carrier**2  # sums of s^2 + c^2, and of (c + i s)^2
    ss, cc, sc = 0.5 * (total - turned.real), 0.5 * (total + turned.real), 0.5 * turned.imag
    ridge = 1e-3 * total + 1e-150  # a wave longer than the span is a constant, not a difference of giants; of none, 0
    ss, cc = ss + ridge, cc + ridge
    along = wave @ (carrier * r)
    rs, rc = along.imag, along.real
    determinant = ss * cc - sc * sc
    sine, cosine = (cc * rs - sc * rc) / determinant, (ss * rc - sc * rs) / determinant
    return np.stack([sine * rs + cosine * rc, sine, cosine])
