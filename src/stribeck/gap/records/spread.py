"""How widely each row of a residual scatters: its own noise, and an even part for what no model explains yet.

Encoder noise turns into many times more torque around a reversal, where friction changes sign, than in motion. Rows
that count alike would let that noise hide what the quiet rows show.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import optimize

LEAST = 0.1  # of a joint's noise, that every row has: what is quieter still is not counted on


@dataclass(frozen=True)
class Noise:
    """The noise floor row by row, N m rms: ``fit`` (M, n) on the fitted runs, ``held`` (K, n) on the held-out ones.

    ``drawn`` (M + K, n) is the encoder's part of it on all runs by one draw, N^2 m^2, beside which another model's own
    by the same draw is held.
    """

    fit: np.ndarray
    held: np.ndarray
    drawn: np.ndarray | None = None

    @property
    def rms(self) -> np.ndarray:
        """Noise floor (n,) of the held-out runs, N m rms."""
        return np.asarray(np.sqrt(np.mean(self.held**2, axis=0)))

    def power(self, floor: np.ndarray, own: np.ndarray | None = None) -> np.ndarray:
        """Return the noise (M + K, n) of all rows, N^2 m^2; what a floor (n,) has beyond it is spread evenly.

        A model in whose rows there is more or less by the same draw, its ``own`` (M + K, n; nan: not known), has so
        much more or less. A bristle has less around a reversal, where noise turns the sign of a velocity; it cannot
        gain by that where there is none: of any size, on arms without one, it leaves several times as much.
        """
        known = np.concatenate([self.fit, self.held]) ** 2
        if own is not None and self.drawn is not None:
            change = np.where(np.isfinite(own), own - self.drawn, 0.0)
            known = np.maximum(known + change, LEAST**2 * np.mean(known, axis=0))
        return np.asarray(known + np.maximum(floor**2 - self.rms**2, 0.0))


def noise_power(noise: Noise | None, floor: np.ndarray, rows: int, own: np.ndarray | None = None) -> np.ndarray:
    """Return the noise (rows, n) of the first rows, as :meth:`Noise.power`; the floor's (n,) where none is known."""
    return np.broadcast_to(floor**2, (rows, len(floor))) if noise is None else noise.power(floor, own)[:rows]


def spread(residual: np.ndarray, power: np.ndarray) -> np.ndarray:
    """Return the standard deviation (M, n) of the rows of a residual (M, n), N m.

    Parameters
    ----------
    residual : array (M, n)
        N m.
    power : array (M, n)
        Noise that is known, N^2 m^2.

    Notes
    -----
    The noise, and an even variance such that the mean of the squared residual over the sum is one (Paule & Mandel
    1982): none at the floor, while a large gap makes all rows alike. Rows that are zero, as of a joint that a brake
    holds, tell nothing.
    """
    even = [_even(residual[:, j] ** 2, power[:, j]) for j in range(residual.shape[1])]
    return np.asarray(np.sqrt(power + np.array(even)))


def _even(squares: np.ndarray, power: np.ndarray) -> float:
    told = squares > 0.0
    squares, power = squares[told], power[told]
    if not len(squares):
        return 0.0

    def excess(even: float) -> float:
        return float(np.mean(squares / (power + even))) - 1.0

    most = 2.0 * float(np.mean(squares))  # once would do but for rounding, where the noise is next to nothing
    if most == 0.0 or excess(0.0) <= 0.0:
        return 0.0
    # as a part of the most: a root finder's absolute tolerance is no N^2 m^2
    return most * float(optimize.brentq(lambda part: excess(part * most), 0.0, 1.0, rtol=1e-6))


def levels(residual: np.ndarray, power: np.ndarray, floor: np.ndarray) -> np.ndarray:
    """Return factors (M, n) that make all rows scatter alike, and each joint's noise the floor (n,), N m rms.

    ``residual`` and ``power`` are those of :func:`spread`.
    """
    factor = 1.0 / spread(residual, power)
    return np.asarray(factor * floor / np.sqrt(np.mean(power * factor**2, axis=0)))
