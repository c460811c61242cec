"""A residual whose derivatives by the lateness of a position record are secants.

Friction leaps wherever the velocity reverses, and a record that is moved in time moves all reversals. The derivative at
a point is that of the few samples on which a leap is about to happen, and makes a fit stand still far from the truth.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from stribeck.identify.conditioning import Conditioned
from stribeck.identify.residual import Residual
from stribeck.model.path import SignalPath


class Shifted(Residual):
    """As :class:`Residual`, some columns of its Jacobian by central secants.

    Parameters
    ----------
    path, runs : SignalPath, sequence of Conditioned
    steps : mapping
        Half the width of the secant of each parameter that has one, s.
    columns, observe : sequence of int or None, bool
        As of :class:`Residual`.
    """

    dear = True

    def __init__(
        self,
        path: SignalPath,
        runs: Sequence[Conditioned],
        steps: Mapping[int, float],
        columns: Sequence[int] | None = None,
        *,
        observe: bool = True,
    ) -> None:
        super().__init__(path, runs, columns, observe=observe)
        self.steps = steps
        self._plain = Residual(path, runs, (), observe=observe)

    def along(self, runs: Sequence[Conditioned]) -> Shifted:
        """Return the same residual along other runs."""
        other = super().along(runs)
        assert isinstance(other, Shifted)
        other._plain = self._plain.along(runs)
        return other

    def __call__(self, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the residual (M, n) and its Jacobian (M, n, columns) at physical parameter values (p,)."""
        r, jacobian = super().__call__(p)
        for k, i in enumerate(self.columns):
            if i in self.steps:
                (below, first), (above, last) = (self._moved(p, i, side) for side in (-1.0, 1.0))
                jacobian[..., k] = (last - first) / (above - below)
        return r, jacobian

    def _moved(self, p: np.ndarray, i: int, side: float) -> tuple[float, np.ndarray]:
        """Return one end of a secant: the parameter's value, and the residual (M, n) there."""
        entry, moved = self.path.entries[i], p.copy()
        moved[i] = np.clip(p[i] + side * self.steps[i], entry.lower, entry.upper)
        return float(moved[i]), self.value(moved)

    def value(self, p: np.ndarray) -> np.ndarray:
        """Return the residual (M, n) alone."""
        return self._plain.value(p)
