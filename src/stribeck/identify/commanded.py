"""Whether the recorded torques can be those that the arm file is about: their place, size, sign and unit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stribeck.arm import Arm, unit_at
from stribeck.identify.braked import STRAYS
from stribeck.identify.conditioning import Conditioned
from stribeck.identify.exchanged import exchanged
from stribeck.identify.residual import Residual
from stribeck.model.path import SignalPath
from stribeck.run import Run

ROUNDED = 1.001  # of a limit: what rounding in a log adds
CHECK = "check the limit, and the torque's unit; a drive that gives no more saturates"
ALIKE = 0.7  # correlation of what is commanded with what is needed, from which the one is meant to be the other
FACTOR = 5.0  # by which it may be more or less: no gain of a drive is off by as much


def doubtful_torques(arm: Arm, runs: Sequence[Run], noise: np.ndarray) -> list[str]:
    """Return a warning for each joint that moves without any torque, or with more than its ``torque_limit``.

    Or whose columns have changed places.

    Parameters
    ----------
    arm : Arm
    runs : sequence of Run
        All recordings: a joint may well be asked for nothing in some of them.
    noise : array (n,)
        Standard deviation of the recorded positions, rad.
    """
    said = exchanged(arm, runs)
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


def doubtful_commands(path: SignalPath, p: np.ndarray, runs: Sequence[Conditioned]) -> list[str]:
    """Return the warnings of :func:`commands_beside` for a model along runs.

    Parameters
    ----------
    path : SignalPath
    p : array (p,)
        Parameter values, SI.
    runs : sequence of Conditioned
    """
    asked = np.concatenate([run.filtered(run.command) for run in runs])
    return commands_beside(asked, asked - Residual(path, runs, ())(p)[0], path.arm.names)


def commands_beside(asked: np.ndarray, needed: np.ndarray, names: Sequence[str]) -> list[str]:
    """Return a warning for each joint whose commands are a multiple of what the arm file's model needs, or against it.

    Parameters
    ----------
    asked, needed : array (M, n)
        Commands, and torques that the model needs along the motion, N m.
    names : sequence of str
        Of the joints.
    """
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
