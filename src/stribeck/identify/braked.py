"""Joints that a recording does not drive. One that it does not move either is held, by a brake or a pin, at any torque.

Of a held joint no law can be learnt: what holds it is no friction that it would move against. One that others swing
balances at any scale of its masses: no torque is measured that holds against them.
"""

from __future__ import annotations

import numpy as np

from stribeck.arm import Arm
from stribeck.run import Run

DRIVEN = 0.1  # of its Coulomb friction, that the torque of a joint comes to whose drive does anything
WINDOW = 0.1  # s, whose mean positions are compared
WITHIN = 4.0  # standard deviations of noise, within which they all lie: one step of an encoder
STRAYS = 20.0  # standard deviations of its noise, from end to end, that no record of a joint at rest strays


def braked(arm: Arm, run: Run, noise: np.ndarray) -> np.ndarray:
    """Return which joints (n,) stand still all along without a torque, or under one that is the same all along.

    Parameters
    ----------
    arm : Arm
    run : Run
        On a uniform clock.
    noise : array (n,)
        Of the recorded positions, rad.
    """
    return np.asarray(_still(run, noise) & (undriven(arm, run) | (np.ptp(run.tau, axis=0) == 0.0)))


def unmoved(run: Run, noise: np.ndarray) -> np.ndarray:
    """Return which joints (n,) stand still all along, at any torque: none that trembles to and fro within a window."""
    return np.asarray(_still(run, noise) & (np.ptp(run.q, axis=0) <= STRAYS * noise))


def window_means(run: Run) -> tuple[np.ndarray, int]:
    """Return the mean positions (K, n) in the windows of a run, rad, and how many samples a window has."""
    width = min(max(1, round(WINDOW / run.sample_time)), len(run.q))
    count = len(run.q) // width
    return run.q[: count * width].reshape(count, width, run.n).mean(axis=1), width


def undriven(arm: Arm, run: Run) -> np.ndarray:
    """Return at which joints (n,) a run has no torque, or next to none beside friction."""
    least = DRIVEN * np.array([joint.friction.C0 for joint in arm.joints])
    return np.asarray(np.sqrt(np.mean(run.tau**2, axis=0)) <= least)


def _still(run: Run, noise: np.ndarray) -> np.ndarray:
    means, _ = window_means(run)
    return np.asarray(np.ptp(means, axis=0) <= WITHIN * noise)
