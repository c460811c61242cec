"""What noise adds to a residual, as far as masses and inertias tell: so much less of it is theirs to make small.

Acceleration is a record differentiated twice, and holds most of the noise. Less inertia leaves less of it, so that
least squares find too little where a motion shows the inertia for moments, in noise that lasts (errors in variables).
Noise that is added once more adds the same again: what it adds to the cost is taken off, at any values (corrected
score, Nakamura 1990, Biometrika 77:127). Friction stays out of it: its pull near reversals is no parabola, and taking
that off would not end where it is hardly known.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stribeck.identify.conditioning import Conditioned
from stribeck.identify.residual import Residual


class Added:
    """Change of a residual by noise that is added once more.

    Parameters
    ----------
    residual : Residual
    p : array (p,)
        Parameter values: those of friction stay.
    noisier : sequence of sequence of Conditioned
        Its runs with their noise once more, by several draws (:func:`stribeck.identify.noise_pull.louder`).
    """

    def __init__(self, residual: Residual, p: np.ndarray, noisier: Sequence[Sequence[Conditioned]]) -> None:
        entries, columns = residual.path.entries, residual.columns
        self._places = [k for k, i in enumerate(columns) if entries[i].owner != "friction"]
        self._free, self._p = [columns[k] for k in self._places], p
        self._width = len(columns)
        own = Residual(residual.path, residual.runs, self._free)
        self._own, self._noisier = own, [own.along(runs) for runs in noisier]

    def __call__(self, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the rows (M, n) of all draws over one another, (K, M, n), as of one, and their Jacobian."""
        at = self._p.copy()
        at[self._free] = p[self._free]
        r, jacobian = self._own(at)
        noisy = [residual(at) for residual in self._noisier]
        rows = np.stack([one - r for one, _ in noisy])
        slopes = np.zeros((*rows.shape, self._width))
        slopes[..., self._places] = np.stack([one - jacobian for _, one in noisy])
        share = 1.0 / np.sqrt(len(noisy))
        return share * rows, share * slopes
