"""Recorded torques that cannot be all of a drive's doing: none at a joint that moves, more than the arm file allows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stribeck.arm import Arm, unit_at
from stribeck.identify.braked import STRAYS
from stribeck.run import Run

ROUNDED = 1.001  # of a limit: what rounding in a log adds
CHECK = "check the limit, and the torque's unit; a drive that gives no more saturates"


def doubtful_torques(arm: Arm, runs: Sequence[Run], noise: np.ndarray) -> list[str]:
    """Return a warning for each joint that moves without any torque, or with more than its ``torque_limit``.

    Parameters
    ----------
    arm : Arm
    runs : sequence of Run
        All recordings: a joint may well be asked for nothing in some of them.
    noise : array (n,)
        Standard deviation of the recorded positions, rad.
    """
    said = []
    for j, joint in enumerate(arm.joints):
        peak = max(float(np.max(np.abs(run.tau[:, j]))) for run in runs)
        way = max(float(np.ptp(run.q[:, j])) for run in runs)
        if peak == 0.0 and way > STRAYS * noise[j]:
            what = f"{joint.name}: it moves, but its torque is zero in every recording"
            said.append(f"{what}: give what was commanded as tau{j + 1}, unless it has no drive")
        if joint.torque_limit is not None and peak > ROUNDED * joint.torque_limit:
            unit = unit_at("N m", joint.kind)
            limit = f"its torque_limit of {joint.torque_limit:.3g} {unit}"
            said.append(f"{joint.name}: {peak:.3g} {unit} recorded, beyond {limit}: {CHECK}")
    return said
