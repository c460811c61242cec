"""The way down from a candidate's start, in steps of its own parameters, all others following."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stribeck.gap.fitted.model import HUGE
from stribeck.gap.search.projector import Projector
from stribeck.identify.residual import Residual

REACH = 50.0  # typical sizes that one step may go: far, for it is taken back where it does not help
LEAST_DAMPING = 1e-3
LITTLE = 0.02  # of the cost saved: a step that promises less is not made


class Descent:
    """How far down one comes from a start, step by step.

    Parameters
    ----------
    residual : Residual
        Its columns those of ``own``.
    projector : Projector
    p : array (p,)
        The start.
    own : sequence of int
        The parameters that steps change.
    unit : array (own,)
        Typical sizes.

    Attributes
    ----------
    saved : float
        The largest cost reduction met.
    p : array (p,)
        All values there.
    ahead : float
        What the next step from there promises in all.
    """

    def __init__(
        self, residual: Residual, projector: Projector, p: np.ndarray, own: Sequence[int], unit: np.ndarray
    ) -> None:
        self._residual, self._projector, self._own, self._unit = residual, projector, own, unit
        entries = [residual.path.entries[i] for i in own]
        self._log = np.array([entry.log for entry in entries], dtype=bool)
        self._bounds = tuple(np.array([getattr(entry, side) for entry in entries]) for side in ("lower", "upper"))
        self._curvature, self._downhill = np.zeros((len(own), len(own))), np.zeros(len(own))
        self._damping = LEAST_DAMPING
        self._next: np.ndarray | None = p
        self.saved, self.p, self.ahead = -np.inf, p, -np.inf

    def go(self, steps: int) -> None:
        """Evaluate so many more places, at most."""
        for _ in range(steps):
            if self._next is None:
                break
            self._next = self._after(self._next)

    def _after(self, p: np.ndarray) -> np.ndarray | None:
        """Return where to go after a place; None where the way ends."""
        own, log = self._own, self._log
        r, jacobian = self._residual(p)
        slope = np.where(log, p[own], 1.0) * self._unit
        saved = -np.inf
        if np.all(np.abs(r) < HUGE) and np.all(np.abs(jacobian * slope) < HUGE):
            saved, *equations = self._projector.step(r, jacobian * slope)
        if saved > self.saved:
            self.saved, self.p, self._damping = saved, p, max(self._damping / 10.0, LEAST_DAMPING)
            self._curvature, self._downhill = equations
        elif np.isfinite(self.saved):
            self._damping *= 30.0
        else:
            return None
        step = np.clip(_damped(self._curvature, self._downhill, self._damping), -REACH, REACH)
        made = np.where(log, np.clip(step, -1.0, 1.0), step)
        self.ahead = self.saved - float(self._downhill @ made) - 0.5 * float(made @ self._curvature @ made)
        if -0.5 * float(self._downhill @ step) < LITTLE * max(self.saved, 1.0):
            return None
        at, after = self.p[own], self.p.copy()
        grown = at * np.exp(np.where(log, made, 0.0))
        after[own] = np.clip(np.where(log, grown, at + made * self._unit), *self._bounds)
        return after


def _damped(curvature: np.ndarray, slope: np.ndarray, damping: float) -> np.ndarray:
    """Return the step of Levenberg (1944) and Marquardt (1963)."""
    ridge = np.diag(damping * np.diag(curvature) + 1e-9 * np.max(np.diag(curvature)) + 1e-12)
    return np.asarray(np.linalg.solve(curvature + ridge, -slope))
