"""A residual of which a law that is linear in its constants has taken what it can.

The constants follow whatever the other parameters are, so the law needs no entries in the signal path: the residual is
projected off its columns (variable projection, Golub & Pereyra 1973).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from stribeck.identify.conditioning import Conditioned
from stribeck.identify.residual import Residual

Floats = NDArray[np.float64]


class Absorbed(Residual):
    """As another residual, less what some columns can take of it.

    Parameters
    ----------
    whole : Residual
    columns : array (M, n, K)
        Torque by one unit of each constant, N m.
    scale : array (n,) or (M, n)
        Of the rows in the fit (:attr:`stribeck.identify.problem.Weights.scale`).
    """

    def __init__(self, whole: Residual, columns: Floats, scale: Floats) -> None:
        super().__init__(whole.path, whole.runs, whole.columns, observe=whole.observe)
        self.whole, self.dear, self.torque = whole, whole.dear, columns
        self.scale = np.broadcast_to(scale, columns.shape[:2])
        self._inverse = np.linalg.pinv(self._weighted(columns), rcond=1e-9)

    def along(self, runs: Sequence[Conditioned]) -> Residual:
        """Refuse: the columns belong to the runs that they were made for."""
        raise TypeError("a law's torque along other runs is not known here")

    def _weighted(self, values: Floats) -> Floats:
        weighted = values * self.scale[..., None]
        return np.asarray(weighted.reshape(values.shape[0] * values.shape[1], -1))

    def constants(self, values: Floats) -> Floats:
        """Return the constants (K, k) with which the columns take most of some rows (M, n, k)."""
        return np.asarray(self._inverse @ self._weighted(values))

    def __call__(self, p: Floats) -> tuple[Floats, Floats]:
        """Return what is left of the residual (M, n) and of its Jacobian (M, n, columns) at parameter values (p,)."""
        r, jacobian = self.whole(p)
        return self._left(r[..., None])[..., 0], self._left(jacobian)

    def value(self, p: Floats) -> Floats:
        """Return what is left of the residual (M, n) alone."""
        return self._left(self.whole.value(p)[..., None])[..., 0]

    def _left(self, values: Floats) -> Floats:
        return np.asarray(values - self.torque @ self.constants(values))
