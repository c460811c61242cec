"""The two cutoffs by which recordings are filtered: the analysis, and the motion's own filter, as noise allows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stribeck.arm import Arm
from stribeck.identify.braked import braked
from stribeck.identify.filters import smoother
from stribeck.run import Run

NOISE_SHARE = 0.015  # encoder noise after filtering may be this share of the torque
SKIRT = 2.7  # noise that the low-pass lets through above its cutoff, where it is strongest
CUTOFF_RANGE = (5.0, 40.0)  # Hz
MOST_OF_RATE = 0.15  # cutoff as a share of the sample rate, at most
SMOOTHING = 2.5  # the motion's filter lies at least this far above the analysis cutoff
VELOCITY_NOISE = 0.0015  # of the rms speed
MOST_OF_MOTION = 0.35  # the motion's filter as a share of the sample rate, at most


def cutoff_frequency(arm: Arm, runs: Sequence[Run], inertia: np.ndarray, noise: np.ndarray) -> float:
    """Return the analysis cutoff (Hz): as high as encoder noise, differentiated twice, allows.

    It may be a small share of a joint's torque: of the drive's, or of what swings it where others do. A joint that no
    run moves sets no bound.

    Parameters
    ----------
    arm : Arm
    runs : sequence of Run
    inertia : array (n,)
        Inertia that each joint moves, kg m^2.
    noise : array (n,)
        Of the recorded positions, rad.
    """
    rate = min(1.0 / run.sample_time for run in runs)
    best = min(CUTOFF_RANGE[1], MOST_OF_RATE * rate)
    accelerated = [_acceleration(run) for run in runs]
    for j in np.flatnonzero(~np.all([braked(arm, run, noise) for run in runs], axis=0)):
        torque = max(_rms([run.tau[:, j] for run in runs]), inertia[j] * _rms([swung[:, j] for swung in accelerated]))
        ratio = NOISE_SHARE * torque / (SKIRT * inertia[j] * noise[j] * (2 * np.pi) ** 2)
        best = min(best, float((ratio**2 * 2.5 * rate) ** 0.2))
    return max(best, min(CUTOFF_RANGE[0], MOST_OF_RATE * rate))


def motion_cutoff(run: Run, noise: np.ndarray, cutoff: float) -> float:
    """Return the cutoff of the motion's own filter, Hz: high, so that reversals and stops stay sharp.

    Velocity noise sets it, at a small share of the speed, and the analysis cutoff from below.
    """
    h = run.sample_time
    speed = np.sqrt(np.mean(np.diff(run.q, axis=0) ** 2, axis=0)) / h
    moving = speed > 3.0 * noise / h
    if not moving.any():
        return min(SMOOTHING * cutoff, MOST_OF_MOTION / h)
    # noise s of position leaves 2 pi f s sqrt(2 f h / 3) of velocity below f
    allowed = float(np.min(VELOCITY_NOISE * speed[moving] / noise[moving]))
    sharp = float((allowed / (2 * np.pi)) ** (2 / 3) * (1.5 / h) ** (1 / 3))
    return min(max(sharp, SMOOTHING * cutoff), MOST_OF_MOTION / h)


def _acceleration(run: Run) -> np.ndarray:
    """Return how a run's joints accelerate (N, n) below the lowest cutoff, rad/s^2."""
    h = run.sample_time
    smooth, _, _ = smoother(min(CUTOFF_RANGE[0], MOST_OF_MOTION / h), h)
    return np.asarray(np.gradient(np.gradient(smooth(run.q), h, axis=0), h, axis=0))


def _rms(parts: Sequence[np.ndarray]) -> float:
    return float(np.sqrt(np.mean(np.concatenate(parts) ** 2)))
