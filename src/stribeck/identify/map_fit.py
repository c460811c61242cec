"""Maximum a posteriori fit with IPOPT: the residual along recorded motion, within the arm file's tolerances."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from stribeck.identify.callbacks import Cost, Gradient, Hessian, Stop
from stribeck.identify.residual import Residual
from stribeck.model.layout import Entry, values_of

PRIOR_LIMIT = 3.0  # standard deviations that re-tuning may move a nominal value; more is a gap of its own
FRICTION_LIMIT = 6.0  # the same for friction, which its prior alone holds: other laws would stand in for its level
PATIENCE, WORTH = 10, 1e-3  # evaluations of dear derivatives in which the cost must fall by that part
GOOD = ("Solve_Succeeded", "Solved_To_Acceptable_Level")


@dataclass(frozen=True)
class Weights:
    """How much a residual row counts: ``sd`` (n,) or, row by row, (M, n), N m, and the rows that count as one, (n,)."""

    sd: np.ndarray
    correlation: np.ndarray

    @property
    def scale(self) -> np.ndarray:
        """Factor, of the shape of ``sd``, that turns a residual in N m into one of unit information."""
        return np.asarray(1.0 / (self.sd * np.sqrt(self.correlation)))


@dataclass(frozen=True)
class Fit:
    """A fit and how it ended.

    Attributes
    ----------
    entries : tuple of Entry
        All parameters; ``p`` (p,) their fitted values, ``free`` (f,) the indices that were fitted.
    residual : array (M, n)
        Residual at ``p``, N m. ``jacobian`` (M, n, f), in physical units.
    misfit, prior : float
        Half the weighted sum of squares, and half the prior's chi-square.
    status : str
        IPOPT's return status. ``ok`` tells whether it is a solution.
    at_limit : tuple of str
        Keys of nominal values that the data push to PRIOR_LIMIT standard deviations or beyond.
    """

    entries: tuple[Entry, ...]
    p: np.ndarray
    free: np.ndarray
    residual: np.ndarray
    jacobian: np.ndarray
    misfit: float
    prior: float
    status: str
    iterations: int
    at_limit: tuple[str, ...]

    @property
    def ok(self) -> bool:
        """Whether the solver found a solution."""
        return self.status in GOOD

    @property
    def cost(self) -> float:
        """Misfit and prior together."""
        return self.misfit + self.prior

    def value(self, key: str) -> float:
        """Return one fitted value."""
        return float(self.p[[entry.key for entry in self.entries].index(key)])


class _Problem:
    """The fit in scaled coordinates z: nominal values in standard deviations, effect parameters in their scale."""

    def __init__(self, residual: Residual, weights: Weights, start: np.ndarray, scales: Mapping[str, float]) -> None:
        self.residual, self.weights, self.entries = residual, weights, residual.path.entries
        self.p0 = values_of(self.entries)
        self.free = np.array(residual.columns, dtype=int)
        self.log = np.array([self.entries[i].log for i in self.free], dtype=bool)
        self.has_prior = np.array([np.isfinite(self.entries[i].sd) for i in self.free], dtype=bool)
        self.unit = np.array([self._unit(self.entries[i], scales) for i in self.free])
        self.origin = np.where(self.has_prior, self.p0[self.free], 0.0)
        self.start = np.clip(self._scaled(start), *self.bounds())
        self._cache: tuple[bytes, Any] | None = None
        self.evaluations = 0
        self.fallen = (np.inf, 0)
        self.best = (np.inf, self.start)
        self.last: tuple[bytes, np.ndarray, np.ndarray] = (b"", np.empty(0), np.empty(0))

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
        p[self.free] = np.where(self.log, np.exp(np.where(self.log, z, 0.0)), self.origin + self.unit * z)
        return p

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Return lower and upper bounds of z."""
        lower = np.array([self.entries[i].lower for i in self.free])
        upper = np.array([self.entries[i].upper for i in self.free])
        safe = np.where(self.log, np.maximum(lower, 1e-300), 1.0)
        low = np.where(self.log, np.log(safe), (lower - self.origin) / self.unit)
        high = np.where(self.log, np.log(np.where(self.log, upper, 1.0)), (upper - self.origin) / self.unit)
        friction = np.array([self.entries[i].owner == "friction" for i in self.free], dtype=bool)
        limit = np.where(self.has_prior, np.where(friction, FRICTION_LIMIT, PRIOR_LIMIT), np.inf)
        return np.maximum(low, -limit), np.minimum(high, limit)

    def cost(self, z: np.ndarray) -> float:
        """Return the cost at z; alone where derivatives are dear, as a search along a line asks for no more."""
        if not self.residual.dear or (self._cache is not None and self._cache[0] == z.tobytes()):
            return float(self.evaluate(z)[0])
        weighted = self.residual.value(self.physical(z)) * self.weights.scale
        return self._tried(0.5 * float(np.sum(weighted**2)) + 0.5 * float(np.sum(self.prior(z) ** 2)), z)

    def _tried(self, cost: float, z: np.ndarray) -> float:
        if cost < self.fallen[0] - WORTH * abs(cost):
            self.fallen = (cost, self.evaluations)
        if cost < self.best[0]:
            self.best = (cost, z)
        return cost

    @property
    def stuck(self) -> bool:
        """Whether dear derivatives have led nowhere for a while."""
        return self.residual.dear and self.evaluations - self.fallen[1] >= PATIENCE

    def prior(self, z: np.ndarray) -> np.ndarray:
        return np.where(self.has_prior, z, 0.0)

    def evaluate(self, z: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        """Return cost, gradient and Gauss-Newton Hessian at z."""
        key = z.tobytes()
        if self._cache is None or self._cache[0] != key:
            self._cache = (key, self._compute(z))
            self.evaluations += 1
            self._tried(self._cache[1][0], z)
        return self._cache[1]

    def _compute(self, z: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        p = self.physical(z)
        r, jacobian = self.residual(p)
        self.last = (z.tobytes(), r, jacobian)
        slope = np.where(self.log, p[self.free], self.unit)
        weighted = (r * self.weights.scale).ravel()
        columns = (jacobian * self.weights.scale[..., None]).reshape(len(weighted), -1) * slope
        prior = self.prior(z)
        cost = 0.5 * float(weighted @ weighted) + 0.5 * float(prior @ prior)
        return cost, columns.T @ weighted + prior, columns.T @ columns + np.diag(self.has_prior.astype(float))


def fit(
    residual: Residual,
    weights: Weights,
    start: np.ndarray | None = None,
    scales: Mapping[str, float] | None = None,
    *,
    evaluations: int = 80,
    tolerance: float = 1e-4,
) -> Fit:
    """Fit the free parameters of a path to recorded runs.

    Parameters
    ----------
    residual : Residual
    weights : Weights
        Of the rows, per joint.
    start : array (p,) or None
        Where to start; the nominal values where None.
    scales : mapping
        Typical size of each effect parameter by key, for conditioning.
    evaluations : int
        About so many evaluations of the residual at most.
    tolerance : float
        On the scaled gradient, relative to the cost's own uncertainty of one unit.

    Notes
    -----
    Gauss-Newton Hessian, gradient as the residual has it. Where derivatives are dear, they alone are counted as
    evaluations, and PATIENCE of them that lead nowhere end the fit: its status is No_Further_Descent. Nominal values
    stay within PRIOR_LIMIT prior standard deviations, those of
    friction within FRICTION_LIMIT.
    """
    p0 = values_of(residual.path.entries) if start is None else start
    problem = _Problem(residual, weights, p0, scales or {})
    cost, gradient, hessian = Cost(problem), Gradient(problem), Hessian(problem)
    z = ca.MX.sym("z", len(problem.free))
    stop = Stop(problem, evaluations)
    options = {
        "grad_f": gradient,
        "iteration_callback": stop,
        "hess_lag": hessian,
        "print_time": False,
        "calc_lam_p": False,
        "no_nlp_grad": True,
        "ipopt": {
            "print_level": 0,
            "sb": "yes",
            "max_iter": evaluations,
            "tol": tolerance,
            # the cost is in units of information: a change below a ten-thousandth of it decides nothing
            "acceptable_tol": 1e10,
            "acceptable_dual_inf_tol": 1e10,
            "acceptable_obj_change_tol": 1e-4,
            "acceptable_iter": 2,
            "mu_strategy": "adaptive",
            "nlp_scaling_method": "none",
            "bound_relax_factor": 0.0,
            "honor_original_bounds": "yes",
            # a law with a kink (contact, a dead zone) can defeat the line search: move on rather than stall
            "accept_after_max_steps": 4,
        },
    }
    solver = ca.nlpsol("fit", "ipopt", {"x": z, "f": cost(z)}, options)
    lower, upper = problem.bounds()
    solution = solver(x0=problem.start, lbx=lower, ubx=upper)
    found = solution["x"].full().ravel()
    if problem.evaluate(found)[0] > problem.best[0]:
        found = problem.best[1]
    return _result(problem, found, solver.stats())


def _result(problem: _Problem, z: np.ndarray, stats: Mapping[str, Any]) -> Fit:
    p = problem.physical(z)
    key, r, jacobian = problem.last
    if key != z.tobytes():
        r, jacobian = problem.residual(p)
    weighted = r * problem.weights.scale
    prior = problem.prior(z)
    pushed = np.abs(prior) > PRIOR_LIMIT - 1e-2
    keys = tuple(problem.entries[i].key for i, flag in zip(problem.free, pushed, strict=True) if flag)
    return Fit(
        entries=problem.entries,
        p=p,
        free=problem.free,
        residual=r,
        jacobian=jacobian,
        misfit=0.5 * float(np.sum(weighted**2)),
        prior=0.5 * float(prior @ prior),
        status="No_Further_Descent" if problem.stuck else str(stats["return_status"]),
        iterations=int(stats["iter_count"]),
        at_limit=keys,
    )
