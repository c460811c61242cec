"""A fit as its solver sees it: cost, gradient and Hessian of a residual with priors, in scaled coordinates."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from stribeck.identify.added import Added
from stribeck.identify.residual import Residual
from stribeck.model.layout import Entry, values_of

PRIOR_LIMIT = 3.0  # standard deviations that re-tuning may move a nominal value; more is a gap of its own
FRICTION_LIMIT = 6.0  # the same for what friction does with speed
LEVEL_LIMIT = 30.0  # and for its level, which its prior alone holds: other laws would stand in for it
LEVELS = ("C0", "C2")


@dataclass(frozen=True)
class Weights:
    """How much a residual row counts: ``sd`` (n,) or, row by row, (M, n), N m, and the rows that count as one, (n,)."""

    sd: np.ndarray
    correlation: np.ndarray

    @property
    def scale(self) -> np.ndarray:
        """Factor, of the shape of ``sd``, that turns a residual in N m into one of unit information."""
        return np.asarray(1.0 / (self.sd * np.sqrt(self.correlation)))


def prior_limit(entry: Entry) -> float:
    """Return by how many standard deviations re-tuning may move a nominal value."""
    if entry.owner != "friction":
        return PRIOR_LIMIT
    return LEVEL_LIMIT if entry.name.rpartition(".")[2] in LEVELS else FRICTION_LIMIT


class Problem:
    """The fit in scaled coordinates z: nominal values in standard deviations, effect parameters in their scale.

    Parameters
    ----------
    residual : Residual
    weights : Weights
        Of its rows.
    start : array (p,)
        Parameter values to start from, SI.
    scales : mapping of str to float
        Typical size of each effect parameter by key, SI; 1 where it has none.
    added : Added or None
        What noise adds to the residual: its squares are taken off the cost.
    """

    def __init__(
        self,
        residual: Residual,
        weights: Weights,
        start: np.ndarray,
        scales: Mapping[str, float],
        added: Added | None = None,
    ) -> None:
        self.residual, self.weights, self.entries, self.added = residual, weights, residual.path.entries, added
        self.p0 = values_of(self.entries)
        self.free = np.array(residual.columns, dtype=int)
        self.log = np.array([self.entries[i].log for i in self.free], dtype=bool)
        self.has_prior = np.array([np.isfinite(self.entries[i].sd) for i in self.free], dtype=bool)
        self.unit = np.array([self._unit(self.entries[i], scales) for i in self.free])
        self.origin = np.where(self.has_prior, self.p0[self.free], 0.0)
        self.lower = np.array([self.entries[i].lower for i in self.free])
        self.upper = np.array([self.entries[i].upper for i in self.free])
        self.start = np.clip(self._scaled(start), *self.bounds())
        self._key: bytes | None = None  # of nothing yet: where all values are held, z has no bytes at all
        self._cost, self._rows = (np.inf, np.empty(0), np.empty(0)), (np.empty(0), np.empty(0), np.inf)
        self.evaluations = 0
        self.best, self.first = (np.inf, self.start), np.inf

    @staticmethod
    def _unit(entry: Entry, scales: Mapping[str, float]) -> float:
        if np.isfinite(entry.sd):
            return entry.sd
        return 1.0 if entry.log else scales.get(entry.key, 1.0)

    def _scaled(self, p: np.ndarray) -> np.ndarray:
        values = p[self.free]
        linear = (values - self.origin) / self.unit
        return np.where(self.log, np.log(np.where(self.log, np.maximum(values, 1e-300), 1.0)), linear)

    def physical(self, z: np.ndarray) -> np.ndarray:
        """Return all parameter values (p,) at scaled coordinates."""
        p = self.p0.copy()
        values = np.where(self.log, np.exp(np.where(self.log, z, 0.0)), self.origin + self.unit * z)
        p[self.free] = np.clip(values, self.lower, self.upper)  # where one rests, rounding leads beyond
        return p

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Return lower and upper bounds of z."""
        safe = np.where(self.log, np.maximum(self.lower, 1e-300), 1.0)
        low = np.where(self.log, np.log(safe), (self.lower - self.origin) / self.unit)
        high = np.where(self.log, np.log(np.where(self.log, self.upper, 1.0)), (self.upper - self.origin) / self.unit)
        limit = np.where(self.has_prior, [prior_limit(self.entries[i]) for i in self.free], np.inf)
        return np.maximum(low, -limit), np.minimum(high, limit)

    def prior(self, z: np.ndarray) -> np.ndarray:
        """Return how far each value is from its nominal one (f,), in standard deviations; 0 where it has none."""
        return np.where(self.has_prior, z, 0.0)

    def evaluate(self, z: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        """Return cost, gradient and Gauss-Newton Hessian at z."""
        if self._key != z.tobytes():
            self._key, self._cost = z.tobytes(), self._compute(z)
            self.evaluations += 1
            if self.first == np.inf:
                self.first = self._cost[0]
            if self._cost[0] < self.best[0]:
                self.best = (self._cost[0], z)
        return self._cost

    def rows(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
        """Return the residual (M, n), its Jacobian (M, n, f) and half its weighted sum of squares at z."""
        self.evaluate(z)
        return self._rows

    def squared(self, z: np.ndarray) -> np.ndarray:
        """Return residuals (M n), in units of information, and priors (f,): half their squares are the cost."""
        r = self.residual.value(self.physical(z))
        with np.errstate(over="ignore", invalid="ignore"):  # a trial step may run away: a fit turns back there
            return np.concatenate([(r * self.weights.scale).ravel(), self.prior(z)])

    def slopes(self, z: np.ndarray) -> np.ndarray:
        """Return the derivatives (M n + f, f) of :meth:`squared`."""
        _, jacobian, _ = self.rows(z)
        return np.concatenate([self._columns(jacobian, self.physical(z)), np.diag(self.has_prior.astype(float))])

    def _columns(self, jacobian: np.ndarray, p: np.ndarray) -> np.ndarray:
        weighted = jacobian * self.weights.scale[..., None]
        return np.asarray(weighted.reshape(math.prod(weighted.shape[:2]), -1) * self._slope(p))

    def _slope(self, p: np.ndarray) -> np.ndarray:
        """Return by how much physical values change with scaled ones."""
        return np.where(self.log, p[self.free], self.unit)

    def _compute(self, z: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        p = self.physical(z)
        with np.errstate(over="ignore", invalid="ignore"):  # as in ``squared``
            r, jacobian = self.residual(p)
            weighted, columns, prior = (r * self.weights.scale).ravel(), self._columns(jacobian, p), self.prior(z)
            misfit = 0.5 * float(weighted @ weighted)
            self._rows = r, jacobian, misfit
            cost = misfit + 0.5 * float(prior @ prior)
            gradient = columns.T @ weighted + prior
            if self.added is not None:
                rows, slopes = self.added(p)
                rows = rows * self.weights.scale
                cost -= 0.5 * float(np.sum(rows**2))
                gradient -= np.einsum("kmn,kmnf->f", rows * self.weights.scale, slopes) * self._slope(p)
            return cost, gradient, columns.T @ columns + np.diag(self.has_prior.astype(float))
