"""Derivatives along the way of a fit: taken where those before do not hold any more.

With a play at a joint, those by all parameters take a dozen times as long as the residual itself.
"""

from __future__ import annotations

import numpy as np

from stribeck.identify.problem import Problem

HUGE = 1e100  # of what is squared: a trial step that comes there has run away
TRUE = 0.75  # of the fall that slopes foretold has come true: they are believed for one more step


class Slopes:
    """Derivatives that follow the steps of a fit (Broyden 1965) while the cost falls as they say.

    Parameters
    ----------
    problem : Problem

    Attributes
    ----------
    own : bool
        Whether the last ones were taken where they were asked for.
    """

    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        self._last: tuple[np.ndarray, np.ndarray] = (np.empty(0), np.empty(0))
        self._known: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None
        self.own = False

    def squared(self, z: np.ndarray) -> np.ndarray:
        """Return residuals (M n + f,) of which half the squares are the cost; infinite where they run away."""
        at, values = self._last
        if np.array_equal(z, at):
            return values
        values = self._problem.squared(z)
        values = values if np.all(np.abs(values) < HUGE) else np.full_like(values, np.inf)
        self._last = z.copy(), values
        return values

    def __call__(self, z: np.ndarray) -> np.ndarray:
        """Return their derivatives (M n + f, f)."""
        values = self.squared(z)
        slopes = None if self._known is None else _followed(z, values, *self._known)
        self.own = slopes is None
        if slopes is None:
            slopes = self._problem.slopes(z)
        self._known = z.copy(), values, slopes
        return slopes

    def forget(self) -> None:
        """Take the next ones where they are asked for."""
        self._known = None


def _followed(
    z: np.ndarray, values: np.ndarray, before: np.ndarray, known: np.ndarray, slopes: np.ndarray
) -> np.ndarray | None:
    """Return the slopes with what a step has changed; None where the cost fell by far less than they had foretold."""
    step, change = z - before, values - known
    told = slopes @ step
    fell, foretold = (float(np.sum((known + by) ** 2) - known @ known) for by in (change, told))
    if not fell < TRUE * foretold:
        return None
    return np.asarray(slopes + np.outer(change - told, step / (step @ step)))
