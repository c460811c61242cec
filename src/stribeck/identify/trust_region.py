"""A fit by secants: within a region that shrinks wherever the cost does not follow them.

Over the width of a secant the cost of a play is smooth, and within it as wrinkled as its blows are many. A search along
a line, as IPOPT's, asks whether the cost falls as its gradient says, finds that it does not, and walks about.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import least_squares

from stribeck.identify.problem import Problem
from stribeck.identify.slopes import Slopes

LITTLE = 1e-4  # of the cost: a step that takes less ends the fit
SHORT = 2e-3  # of the scaled values: so short a step is lost among the wrinkles
INSIDE = 1e-9  # of its bounds a fit must start
LEAST = 3  # evaluations with which a fit still gets anywhere
WORDS = (
    "Maximum_Iterations_Exceeded", "Solve_Succeeded", "Solved_To_Acceptable_Level", "No_Further_Descent",
    "Solved_To_Acceptable_Level",
)  # fmt: skip
SOLVED = (1, 2, 4)  # of these: the cost is as low as it gets


def trust_region(problem: Problem, evaluations: int) -> tuple[np.ndarray, str]:
    """Return where the fit ends (f,), and how, in IPOPT's words.

    Never above its start: SciPy's reflective trust region (Branch, Coleman & Li 1999).

    Parameters
    ----------
    problem : Problem
    evaluations : int
        Of the residual, at most; derivatives at few of the same places. Where slopes that have followed the steps show
        no way down any more, new ones do.
    """
    slopes = Slopes(problem)
    lower, upper = problem.bounds()
    start = np.clip(problem.start, lower + INSIDE, upper - INSIDE)
    if not len(start):
        return start, "Solve_Succeeded"
    if not np.all(np.isfinite(slopes.squared(start))):
        return start, "Invalid_Number_Detected"
    left, cost, status = evaluations, np.inf, 0
    while True:
        found = least_squares(
            slopes.squared, start, slopes, bounds=(lower, upper), ftol=LITTLE, xtol=SHORT, gtol=1e-8, max_nfev=left
        )
        left -= found.nfev
        further = found.cost < (1.0 - LITTLE) * cost
        if further or status not in SOLVED:
            status = found.status
        if slopes.own or not further or left < LEAST:
            unsure = further and not slopes.own
            return found.x, "Maximum_Iterations_Exceeded" if unsure else WORDS[status]
        start, cost = np.clip(found.x, lower + INSIDE, upper - INSIDE), found.cost
        slopes.forget()
