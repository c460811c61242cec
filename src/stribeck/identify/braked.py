"""Joints that a recording does not drive. One that it does not move either is held, by a brake or a pin, at any torque.

Of a held joint no law can be learnt: what holds it is no friction that it would move against. One that others swing
balances at any scale of its masses: no torque is measured that holds against them.
"""

from __future__ import annotations

import numpy as np

from stribeck.run import Run

WINDOW = 0.1  # s, whose mean positions are compared
WITHIN = 4.0  # standard deviations of noise, within which they all lie: one step of an encoder


def braked(run: Run, noise: np.ndarray) -> np.ndarray:
    """Return which joints (n,) stand still all along under a torque that is the same all along.

    Parameters
    ----------
    run : Run
        On a uniform clock.
    noise : array (n,)
        Of the recorded positions, rad.
    """
    means, _ = window_means(run)
    return np.asarray((np.ptp(means, axis=0) <= WITHIN * noise) & (np.ptp(run.tau, axis=0) == 0.0))


def window_means(run: Run) -> tuple[np.ndarray, int]:
    """Return the mean positions (K, n) in the windows of a run, rad, and how many samples a window has."""
    width = min(max(1, round(WINDOW / run.sample_time)), len(run.q))
    count = len(run.q) // width
    return run.q[: count * width].reshape(count, width, run.n).mean(axis=1), width


def undriven(run: Run) -> np.ndarray:
    """Return at which joints (n,) a run has no torque."""
    return np.asarray(~np.any(run.tau, axis=0))
