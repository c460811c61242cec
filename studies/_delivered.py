"""What drives delivered of the torque that they were asked for, where both were recorded."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stribeck.run import Run


def delivered(runs: Sequence[Run], names: Sequence[str]) -> dict[str, float]:
    """Return the slope of measured over commanded torque, which a diagnosis of commanded torque never sees."""
    commanded = np.concatenate([run.tau for run in runs])
    measured = np.concatenate([run.tau_meas for run in runs if run.tau_meas is not None])
    slope = np.sum(commanded * measured, axis=0) / np.sum(commanded**2, axis=0)
    return {name: float(value) for name, value in zip(names, slope, strict=True)}
