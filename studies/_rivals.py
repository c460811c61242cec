"""What a user would write without the package, for comparison."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import OptimizeResult, least_squares

from stribeck.arm import Arm
from stribeck.gap.fitted.corrected import arm_of
from stribeck.identify.conditioning import Conditioned
from stribeck.identify.map_fit import Fit
from stribeck.identify.problem import Weights, prior_limit
from stribeck.model.layout import values_of
from stribeck.withheld.excitation import needed_torque


def least_squares_by_hand(arm: Arm, runs: Sequence[Conditioned], weights: Weights, like: Fit) -> OptimizeResult:
    """Fit a NumPy inverse dynamics by SciPy with finite differences: same data, parameters, prior, bounds as `like`.

    Friction at rest is taken for zero, which is what differs in the residual.
    """
    p0, free = values_of(like.entries), like.free
    sd = np.array([like.entries[i].sd for i in free])
    lower, upper = (np.array([getattr(like.entries[i], side) for i in free]) for side in ("lower", "upper"))

    def residual(z: np.ndarray) -> np.ndarray:
        p = p0.copy()
        p[free] += sd * z
        model = arm_of(arm, replace(like, p=p), ())
        short = [
            run.filtered(run.command - needed_torque(model, run.position, run.velocity, run.acceleration))
            for run in runs
        ]
        return np.concatenate([(np.concatenate(short) * weights.scale).ravel(), z])

    limit = np.array([prior_limit(like.entries[i]) for i in free])
    low, high = np.maximum((lower - p0[free]) / sd, -limit), np.minimum((upper - p0[free]) / sd, limit)
    return least_squares(residual, np.zeros(len(free)), bounds=(low, high))
