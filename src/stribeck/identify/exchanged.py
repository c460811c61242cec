"""Columns that have changed places: a recorded torque that is the encoder's reading, and a position that is none."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stribeck.arm import Arm
from stribeck.quantum import smallest_step
from stribeck.run import Run

ROUGHER = 10.0  # times the torque: a position is the torque integrated twice, and smoother
NEAR = 0.05  # of an encoder's step, that the step of a record may be off it
FOLLOWS = 0.95  # correlation of a rate with the recorded velocity, from which it is that velocity
FASTER = 2.0  # that it may be, or slower


def exchanged(arm: Arm, runs: Sequence[Run]) -> list[str]:
    """Return a warning for each joint whose position and torque have changed places in some recording.

    That takes a position rougher than the torque, and a torque that goes by the encoder's steps, or at the recorded
    velocity; noise alone is no reason.
    """
    said = []
    for j, joint in enumerate(arm.joints):
        for run in runs:
            why = _why(run, j, joint.encoder_resolution)
            if why:
                what = f"{joint.name}: tau{j + 1} of {run.name} is smoother than its q{j + 1}, and {why}"
                said.append(f"{what}: have these columns changed places?")
                break
    return said


def _why(run: Run, j: int, resolution: float | None) -> str:
    """Return what shows that a joint's torque is its position; empty where nothing does."""
    q, tau = run.q[:, j], run.tau[:, j]
    if np.ptp(tau) == 0.0 or np.ptp(q) == 0.0 or _roughness(q) < ROUGHER * _roughness(tau):
        return ""
    if resolution and _on(tau, resolution) and not _on(q, resolution):
        return "goes by the encoder's steps"
    if run.dq is not None and _is_rate(run.dq[:, j], tau, run.t) and not _is_rate(run.dq[:, j], q, run.t):
        return f"changes as dq{j + 1} says"
    return ""


def _roughness(values: np.ndarray) -> float:
    """Return how far values leap to and fro from row to row, as a part of how far they go."""
    return float(np.sqrt(np.mean(np.diff(values, 2) ** 2)) / np.std(values))


def _on(values: np.ndarray, resolution: float) -> bool:
    return abs(smallest_step(values)[0] - resolution) < NEAR * resolution


def _is_rate(rate: np.ndarray, values: np.ndarray, t: np.ndarray) -> bool:
    """Return whether values change at a recorded rate."""
    moved, travelled = np.diff(values), 0.5 * (rate[1:] + rate[:-1]) * np.diff(t)
    power, own = float(travelled @ travelled), float(moved @ moved)
    together = float(moved @ travelled)
    return together > FOLLOWS * np.sqrt(power * own) and 1.0 / FASTER < together / max(power, 1e-300) < FASTER
