"""What noise adds to a model's residual: that of the encoders, and a torque that no model foretells."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import signal

Floats = NDArray[np.float64]

BANDS = 64  # rows of a residual whose spectrum is taken
LEAST = 0.05  # of a torque's power: what hardly passes at all is not known so well


@dataclass(frozen=True)
class Passed:
    """What noise adds to a residual on held-out runs.

    ``encoder`` (n,) is what the encoders' noise adds, and ``torque`` (n,) what 1 N m of white noise in the commands
    does, N m rms, ``spectrum`` (F, n) the latter's power by frequency. ``bristles`` (n,) tells which joints have one:
    around rest they pass on less than the sign of a velocity does.
    """

    encoder: Floats
    torque: Floats
    spectrum: Floats
    bristles: NDArray[np.bool_]

    def known(self, other: Passed) -> NDArray[np.bool_]:
        """Return at which joints (n,) two models' noise can be compared."""
        finite = np.isfinite(self.encoder) & np.isfinite(self.torque) & np.all(np.isfinite(self.spectrum), axis=0)
        return np.asarray(finite & (self.bristles == other.bristles))

    def part_of(self, other: Passed, rows: int) -> Floats:
        """Return the part of a torque's power that this model leaves, another one 1, by frequency; at most 1.

        ``rows`` frequencies (rows, n) from none to the highest that rows of a residual can have.
        """
        ratio = self.spectrum / np.maximum(other.spectrum, 1e-300)
        part = np.where(self.known(other), np.clip(ratio, LEAST, 1.0), 1.0)
        told = np.linspace(0.0, 1.0, len(part))
        asked = np.arange(rows) / rows
        return np.column_stack([np.interp(asked, told, column) for column in part.T])


def spectrum(rows: Floats) -> Floats:
    """Return the power of rows (M, n) by frequency, (F, n)."""
    enough = np.pad(rows, ((0, max(0, BANDS - len(rows))), (0, 0)))
    return np.asarray(signal.welch(enough, nperseg=BANDS, detrend=False, axis=0)[1])
