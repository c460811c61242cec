"""Links that follow the torque a little as well: what noise in the motion stirs up would ring on in them alone.

A link that is driven by the recorded motion of its motor rings at the frequency that it has with the motor held, with
hardly more damping than its spring; the noise of an encoder near that frequency comes out many times as large, and a
fit would take refuge in damping that is not there. The torque that does not balance tells how far the deflection is
off. It corrects the link as a Luenberger observer does, so that the residual is an innovation: what is new in a sample.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import casadi as ca

from stribeck.model.balance import Balance
from stribeck.model.drive import Drive
from stribeck.model.sensitivity import Sensitivity

DAMPING = 0.7  # of critical, up to which the correction damps a link's ringing


def observed(balance: Balance, sample_time: float, now: Drive, carried: Sensitivity, moved: Sensitivity) -> Sensitivity:
    """Return states one sample later (``moved``), corrected by the residual of the sample before (``carried``).

    Joints whose link meets its motor at faces are left alone, and so are links that ring faster than samples show.
    """
    path, x, p = balance.path, carried.states, balance.path.p
    linear = [i for i, face in enumerate(balance.faces) if not face]
    if not linear or balance.contacts:
        return moved
    residual, _ = balance.residual(now, x)
    correction = ca.SX.zeros(x.numel())
    mobility = balance.links(now, x).mobility
    for i in linear:
        stiffness, damping = _slopes(balance, i)
        frequency = ca.sqrt(stiffness * mobility[i, i])
        own = 0.5 * damping * mobility[i, i] / frequency  # of critical: what does not ring needs no correction
        z = sample_time * frequency
        part = 2.0 * ca.fmax(DAMPING - own, 0.0) * z / (1.0 + z**4)
        scale = path.command_scale(path.flexible[i], now.position[path.flexible[i]])
        correction[2 * i] = -part / stiffness * residual[path.flexible[i]] * scale
    columns = ca.jacobian(correction, p)[:, list(carried.parameters)]
    columns += ca.mtimes(ca.jacobian(correction, x), carried.columns)
    return replace(moved, states=moved.states + correction, columns=moved.columns + columns)


def _slopes(balance: Balance, i: int) -> tuple[Any, Any]:
    """Return the stiffness, N m/rad, and the damping, N m s/rad, of the i-th compliance."""
    count = len(balance.path.flexible)
    both = ca.SX.sym("both", 2 * count)
    torque = balance.transmitted(both[:count], both[count:])[i]
    return ca.jacobian(torque, both[i]), ca.jacobian(torque, both[count + i])
