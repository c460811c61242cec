"""What noise adds to a residual, as far as masses and inertias tell: so much less of it is theirs to make small.

Acceleration is a record differentiated twice, and holds most of the noise. Less inertia leaves less of it, so that
least squares find too little where a motion shows the inertia for moments, in noise that lasts (errors in variables).
Noise that is added once more adds the same again: what it adds to the cost is taken off, at any values (corrected
score, Nakamura 1990, Biometrika 77:127). It is what a body without friction has of it while it slides. At reversals
and rests friction is an interval, which hides noise as far as it holds the weight that a mass is given: taking off
what is left would have constants and masses drift along together wherever recordings do not tell them apart.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stribeck.identify.conditioning import Conditioned
from stribeck.identify.residual import Residual
from stribeck.model.balance import FADING, UNSURE
from stribeck.model.effect import FrictionEffect
from stribeck.model.path import SignalPath

SURE = UNSURE + FADING  # standard deviations of velocity, beyond which friction is no interval


class Added:
    """Change of a residual by noise that is added once more.

    Parameters
    ----------
    residual : Residual
    p : array (p,)
        Parameter values; friction is left out of them.
    noisier : sequence of sequence of Conditioned
        Its runs with their noise once more, by several draws (:func:`stribeck.identify.noise_pull.louder`).
    """

    def __init__(self, residual: Residual, p: np.ndarray, noisier: Sequence[Sequence[Conditioned]]) -> None:
        path, columns = residual.path, residual.columns
        smooth = SignalPath(path.arm, [place for place in path.placed if not isinstance(place.effect, FrictionEffect)])
        here = {entry.key: i for i, entry in enumerate(path.entries)}
        self._from = [here[entry.key] for entry in smooth.entries]
        self._none = [e.owner == "friction" and e.name.rpartition(".")[2] != "alpha" for e in smooth.entries]
        self._free = [i for i in columns if path.entries[i].owner == "inertial"]
        self._places = [columns.index(i) for i in self._free]
        self._p, self._width = p, len(columns)
        own = Residual(smooth, residual.runs, [self._from.index(i) for i in self._free])
        self._own, self._noisier = own, [own.along(runs) for runs in noisier]
        self._share = np.sqrt(_sliding(residual.runs) / len(noisier))

    def __call__(self, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the rows (M, n) of all draws over one another, (K, M, n), as of one, and their Jacobian."""
        at = self._p.copy()
        at[self._free] = p[self._free]
        at = np.where(self._none, 0.0, at[self._from])
        r, jacobian = self._own(at)
        noisy = [residual(at) for residual in self._noisier]
        rows = np.stack([one - r for one, _ in noisy])
        slopes = np.zeros((*rows.shape, self._width))
        slopes[..., self._places] = np.stack([one - jacobian for _, one in noisy])
        return self._share * rows, self._share[..., None] * slopes


def _sliding(runs: Sequence[Conditioned]) -> np.ndarray:
    """Return for how much of each row (M, n) a joint surely slides, 0 to 1."""
    parts = []
    for run in runs:
        sure = np.abs(run.velocity) > SURE * run.velocity_sd + run.instant * np.abs(run.acceleration)
        parts.append(run.filtered(sure.astype(float)))
    return np.asarray(np.clip(np.concatenate(parts), 0.0, 1.0))
