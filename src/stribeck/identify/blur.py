"""What the motion's filter leaves in a residual: around reversals and break-aways it rounds the corners of the motion.

The residual's change when that filter is made softer shows how much; an effect of the arm does not change with it.
"""

from __future__ import annotations

import numpy as np

from stribeck.identify.conditioning import condition
from stribeck.identify.residual import Residual

SOFTER = 0.6  # of the motion filter's cutoff
CHANGE = 1.0 / SOFTER**2 - 1.0  # at that cutoff over the error at the full one, where it falls with its square
# The part of the blur that a re-tuned residual still has. Of 145 recordings of five plants without an effect it leaves
# nine of ten within 1.3 floors; of those below 250 Hz, where most is blur, 0.15 would leave three of four within 1.75.
FELT = 0.6


def blur(residual: Residual, p: np.ndarray, cutoff: float) -> np.ndarray:
    """Return what filtering leaves in a residual (M, n), N m.

    Parameters
    ----------
    residual : Residual
        Along its own, thinned runs.
    p : array (p,)
        Values of its path's parameters.
    cutoff : float
        Analysis cutoff of the runs, Hz.
    """
    arm, runs = residual.path.arm, residual.runs
    soft = [condition(arm, run.run, cutoff, run.noise, thin=True, sharpness=SOFTER).as_recorded(run) for run in runs]
    return np.asarray(FELT * (residual.along(soft).value(p) - residual.value(p)) / CHANGE)
