"""Whether the commands are the torques that the arm file is about: their sign, their unit, this side of the gear."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stribeck.gap.records.prepare import Prepared
from stribeck.gap.records.regions import analysis_signals

ALIKE = 0.7  # correlation of what is commanded with what is needed, from which the one is meant to be the other
FACTOR = 5.0  # by which it may be more or less: no gain of a drive is off by as much


def told_commands(prepared: Prepared, given: np.ndarray) -> list[str]:
    """Return a warning for each joint whose commands are a multiple of what the arm file's model needs, or against it.

    Parameters
    ----------
    prepared : Prepared
    given : array (M, n)
        Residual of that model on the held-out runs, N m.
    """
    asked = analysis_signals(prepared.held)["command"]
    return commands_beside(asked, asked - given, prepared.arm.names)


def commands_beside(asked: np.ndarray, needed: np.ndarray, names: Sequence[str]) -> list[str]:
    """Return the warnings of :func:`told_commands` for commands and needs (M, n) of the joints, N m."""
    told = []
    for j, name in enumerate(names):
        together, power = float(asked[:, j] @ needed[:, j]), float(needed[:, j] @ needed[:, j])
        size = float(np.sqrt(power * (asked[:, j] @ asked[:, j])))
        if size == 0.0 or abs(together) < ALIKE * size:
            continue
        times = together / power
        if 1.0 / FACTOR < times < FACTOR:
            continue
        unit = "its unit, and whether it is the motor's or the joint's"
        check = "the signs of its torque and position" if times < 0.0 else unit
        told.append(f"{name}: the command is {times:.3g} times what the arm file's model needs: check {check}")
    return told
