"""Bisection of an expression, unrolled."""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca

from stribeck.model.values import Expression


def bisected(
    excess: Callable[[Expression], Expression], middle: Expression, reach: Expression, steps: int
) -> Expression:
    """Return where an expression turns from negative to positive, to within reach / 2^steps.

    The widths of the steps are known ahead and the sign of the excess alone decides their direction: no derivative
    runs through them. A step of Newton's method behind them carries all of it.

    Parameters
    ----------
    excess : callable
        Returns the expression at a value; at most 0 at ``middle - reach``, at least 0 at ``middle + reach``.
    middle, reach : expression
    steps : int
    """
    value = middle
    for _ in range(steps):
        reach = 0.5 * reach
        value = value - reach * ca.sign(excess(value))
    return value
