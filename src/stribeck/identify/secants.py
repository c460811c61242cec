"""A residual with secants for derivatives, where those at a point say nothing of what lies a step away.

A link that has play strikes its motor again and again; when it does next depends on all blows before. The derivative
of a residual along a recording is that of a few blows that are about to fall a little sooner, hundreds of times too
large, and a fit by it may stand still far from anywhere. Over steps as large as a fit takes, the residual is smooth.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stribeck.identify.conditioning import Conditioned
from stribeck.identify.drives import delays_of
from stribeck.identify.residual import Residual
from stribeck.model.path import SignalPath


class Secants(Residual):
    """As :class:`Residual`, its Jacobian by secants; a column whose secant is none, or no number, is zero.

    Parameters
    ----------
    path, runs : SignalPath, sequence of Conditioned
    steps : array (p,)
        Half the width of each parameter's secant, relative to its value where it is fitted as a logarithm.
    columns, observe : sequence of int or None, bool
        As of :class:`Residual`.
    """

    dear = True

    def __init__(
        self,
        path: SignalPath,
        runs: Sequence[Conditioned],
        steps: np.ndarray,
        columns: Sequence[int] | None = None,
        *,
        observe: bool = True,
    ) -> None:
        super().__init__(path, runs, columns, observe=observe)
        self.steps = steps

    @property
    def _derived(self) -> tuple[int, ...]:
        return ()

    def __call__(self, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the residual (M, n) and its Jacobian (M, n, columns) at physical parameter values (p,)."""
        trials = [p]
        ends = [[self._trial(trials, i, side) for side in self._sides(i, p)] for i in self.columns]
        values = self._values(trials)
        jacobian = np.empty((*values[0].shape, len(self.columns)))
        for k, (i, (below, above)) in enumerate(zip(self.columns, ends, strict=True)):
            width = trials[above][i] - trials[below][i]
            change = values[above] - values[below]
            jacobian[..., k] = change / width if width > 0.0 and np.all(np.isfinite(change)) else 0.0
        return values[0], jacobian

    def _sides(self, i: int, p: np.ndarray) -> tuple[float, float]:
        """Return where a parameter's secant ends, in steps: a nominal value's, all but a line, is one-sided."""
        entry = self.path.entries[i]
        if not np.isfinite(entry.sd):
            return -1.0, 1.0
        return (0.0, 1.0) if p[i] < entry.upper else (-1.0, 0.0)

    def _trial(self, trials: list[np.ndarray], i: int, side: float) -> int:
        """Return the place of the values with one parameter moved, added to the trials where it is not there."""
        if side == 0.0:
            return 0
        entry, p = self.path.entries[i], trials[0].copy()
        step = self.steps[i] * (p[i] if entry.log else 1.0)
        moved = np.clip(p[i] + side * step, entry.lower, entry.upper)
        if moved == p[i]:
            return 0  # at its bound
        p[i] = moved
        trials.append(p)
        return len(trials) - 1

    def value(self, p: np.ndarray) -> np.ndarray:
        """Return the residual (M, n) alone, all runs side by side."""
        return super().__call__(p)[0]

    def _values(self, trials: Sequence[np.ndarray]) -> list[np.ndarray]:
        """Return the residual (M, n) at each of some parameter values, which advance side by side."""
        late: dict[bytes, list[int]] = {}
        for k, p in enumerate(trials):
            late.setdefault(delays_of(self.path, p).tobytes(), []).append(k)
        out = [np.empty(0)] * len(trials)
        for together in late.values():
            values, delays = [trials[k] for k in together], delays_of(self.path, trials[together[0]])
            drives = self._drives.at(delays)
            along = self._states_at(drives, values, delays)
            for k, p, states in zip(together, values, zip(*along, strict=True), strict=True):
                parts = [self._one(*one, p, delays)[0] for one in zip(self.runs, drives, states, strict=True)]
                out[k] = np.concatenate(parts)
        return out
