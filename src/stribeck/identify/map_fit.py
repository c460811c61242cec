"""Maximum a posteriori fit: the residual along recorded motion, within the arm file's tolerances.

With IPOPT; by secants within a trust region.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from stribeck.identify.added import Added
from stribeck.identify.callbacks import Cost, Gradient, Hessian, Stop
from stribeck.identify.interrupts import held_back
from stribeck.identify.problem import PRIOR_LIMIT, Problem, Weights
from stribeck.identify.residual import Residual
from stribeck.identify.trust_region import trust_region
from stribeck.model.layout import Entry, values_of

GOOD = ("Solve_Succeeded", "Solved_To_Acceptable_Level")

# a law with a kink (contact, a dead zone) can defeat the line search: move on rather than stall
BOLD: Mapping[str, object] = {"mu_strategy": "adaptive", "accept_after_max_steps": 4}
# a wave's pitch leaps where the first step is bent by far bounds or taken though the cost rises
CAREFUL: Mapping[str, object] = {"mu_strategy": "monotone", "mu_init": 1e-4}


@dataclass(frozen=True)
class Fit:
    """A fit and how it ended.

    Attributes
    ----------
    entries : tuple of Entry
        All parameters.
    p : array (p,)
        Their fitted values, SI.
    free : array (f,) of int
        Which of them were fitted.
    residual : array (M, n)
        Residual at ``p``, N m.
    jacobian : array (M, n, f)
        Its derivatives by the fitted ones, in physical units.
    misfit, prior : float
        Half the weighted sum of squares, and half the prior's chi-square.
    status : str
        How the solver ended, in IPOPT's words. ``ok`` tells whether it is a solution.
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


def fit(
    residual: Residual,
    weights: Weights,
    start: np.ndarray | None = None,
    scales: Mapping[str, float] | None = None,
    *,
    added: Added | None = None,
    careful: bool = False,
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
    added : Added or None
        What noise adds to the residual: its squares are taken off the cost.
    careful : bool
        Whether every step has to descend, from a start that is believed. A fit that finds nothing better than its start
        is done again the other way.
    evaluations : int
        About so many evaluations of the residual at most.
    tolerance : float
        On the scaled gradient, relative to the cost's own uncertainty of one unit.

    Notes
    -----
    Gauss-Newton Hessian, gradient as the residual has it. Where that is not quite the cost's (``Residual.dear``) a
    search along a line is led astray: such a fit goes by :func:`stribeck.identify.trust_region.trust_region` instead.
    Nominal values stay within PRIOR_LIMIT prior standard deviations, those of friction's level within LEVEL_LIMIT, the
    rest of friction within FRICTION_LIMIT.
    """
    p0 = values_of(residual.path.entries) if start is None else start
    problem = Problem(residual, weights, p0, scales or {}, added)
    if residual.dear:
        return _result(problem, *trust_region(problem, evaluations))
    usual, other = (CAREFUL, BOLD) if careful else (BOLD, CAREFUL)
    found, status = _solved(problem, evaluations, tolerance, usual)
    if problem.best[0] == problem.first and (status not in GOOD or problem.evaluate(found)[0] > problem.first):
        found, status = _solved(problem, evaluations, tolerance, other)
    if problem.evaluate(found)[0] > problem.best[0]:
        found = problem.best[1]
    return _result(problem, found, status)


def _solved(
    problem: Problem, evaluations: int, tolerance: float, steps: Mapping[str, object]
) -> tuple[np.ndarray, str]:
    """Return where IPOPT ends (f,), and its status."""
    cost, gradient, hessian = Cost(problem), Gradient(problem), Hessian(problem)
    z = ca.MX.sym("z", len(problem.free))
    come: list[int] = []
    stop = Stop(problem, problem.evaluations + evaluations, come)
    options = {
        "grad_f": gradient,
        "iteration_callback": stop,
        "hess_lag": hessian,
        "print_time": False,
        "show_eval_warnings": False,  # where a trial step runs away IPOPT turns back
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
            "nlp_scaling_method": "none",
            "bound_relax_factor": 0.0,
            "honor_original_bounds": "yes",
            **steps,
        },
    }
    solver = ca.nlpsol("fit", "ipopt", {"x": z, "f": cost(z)}, options)
    lower, upper = problem.bounds()
    with held_back(come):
        solution = solver(x0=problem.start, lbx=lower, ubx=upper)
    return solution["x"].full().ravel(), str(solver.stats()["return_status"])


def _result(problem: Problem, z: np.ndarray, status: str) -> Fit:
    p = problem.physical(z)
    r, jacobian, misfit = problem.rows(z)
    prior = problem.prior(z)
    pushed = np.abs(prior) > PRIOR_LIMIT - 1e-2
    keys = tuple(problem.entries[i].key for i, flag in zip(problem.free, pushed, strict=True) if flag)
    return Fit(
        entries=problem.entries,
        p=p,
        free=problem.free,
        residual=r,
        jacobian=jacobian,
        misfit=misfit,
        prior=0.5 * float(prior @ prior),
        status=status,
        at_limit=keys,
    )
