"""A fit's cost, gradient and Hessian in the form that CasADi's interface to IPOPT asks for.

The methods named ``eval`` are CasADi's hook for a function of one's own; no text is evaluated anywhere.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import casadi as ca

from stribeck.identify.problem import Problem


class Gradient(ca.Callback):  # type: ignore[misc]
    """(z, p) -> cost and gradient, in the form that CasADi's NLP interface asks for."""

    def __init__(self, problem: Problem) -> None:
        ca.Callback.__init__(self)
        self.problem = problem
        self.construct("gradient", {})

    def get_n_in(self) -> int:
        """Return the number of arguments."""
        return 2

    def get_n_out(self) -> int:
        """Return the number of results."""
        return 2

    def get_sparsity_in(self, i: int) -> ca.Sparsity:
        """Return the shape of an argument."""
        return ca.Sparsity.dense(len(self.problem.free), 1) if i == 0 else ca.Sparsity(0, 0)

    def get_sparsity_out(self, i: int) -> ca.Sparsity:
        """Return the shape of a result."""
        return ca.Sparsity.dense(1 if i == 0 else len(self.problem.free), 1)

    def eval(self, arg: Sequence[Any]) -> list[Any]:
        """Return the results."""
        cost, gradient, _ = self.problem.evaluate(arg[0].full().ravel())
        return [cost, gradient]


class Stop(ca.Callback):  # type: ignore[misc]
    """Ends IPOPT between iterations once the evaluations are used up; a kinked law can eat any number of them.

    And once a signal has ``come``.
    """

    def __init__(self, problem: Problem, limit: int, come: Sequence[int]) -> None:
        ca.Callback.__init__(self)
        self.problem, self.limit, self.come = problem, limit, come
        self.construct("stop", {})

    def get_n_in(self) -> int:
        """Return the number of arguments."""
        return int(ca.nlpsol_n_out())

    def get_sparsity_in(self, i: int) -> ca.Sparsity:
        """Return the shape of an argument."""
        name, width = ca.nlpsol_out(i), len(self.problem.free)
        if name in ("x", "lam_x"):
            return ca.Sparsity.dense(width, 1)
        return ca.Sparsity.dense(1, 1) if name == "f" else ca.Sparsity(0, 0)

    def eval(self, arg: Sequence[Any]) -> list[Any]:
        """Return the results."""
        return [1 if self.come or self.problem.evaluations >= self.limit else 0]


class Cost(ca.Callback):  # type: ignore[misc]
    """z -> cost."""

    def __init__(self, problem: Problem) -> None:
        ca.Callback.__init__(self)
        self.problem = problem
        self.construct("cost", {})

    def get_sparsity_in(self, i: int) -> ca.Sparsity:
        """Return the shape of an argument."""
        return ca.Sparsity.dense(len(self.problem.free), 1)

    def eval(self, arg: Sequence[Any]) -> list[Any]:
        """Return the results."""
        return [self.problem.evaluate(arg[0].full().ravel())[0]]


class Hessian(ca.Callback):  # type: ignore[misc]
    """(z, p, lam_f, lam_g) -> upper triangle of the Gauss-Newton Hessian."""

    def __init__(self, problem: Problem) -> None:
        ca.Callback.__init__(self)
        self.problem = problem
        self.construct("hessian", {})

    def get_n_in(self) -> int:
        """Return the number of arguments."""
        return 4

    def get_sparsity_in(self, i: int) -> ca.Sparsity:
        """Return the shape of an argument."""
        return [ca.Sparsity.dense(len(self.problem.free), 1), ca.Sparsity(0, 0), ca.Sparsity.dense(1, 1),
                ca.Sparsity(0, 1)][i]  # fmt: skip

    def get_sparsity_out(self, i: int) -> ca.Sparsity:
        """Return the shape of a result."""
        return ca.Sparsity.upper(len(self.problem.free))

    def eval(self, arg: Sequence[Any]) -> list[Any]:
        """Return the results."""
        hessian = self.problem.evaluate(arg[0].full().ravel())[2]
        return [ca.triu(ca.DM(hessian * float(arg[2])))]
