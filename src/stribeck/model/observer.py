"""Links that follow the torque a little as well: what noise in the motion stirs up would ring on in them alone.

A link that is driven by the recorded motion of its motor rings at the frequency that it has with the motor held, with
hardly more damping than its spring; the noise of an encoder near that frequency comes out many times as large, and a
fit would take refuge in damping that is not there. The torque that does not balance tells how far the deflection is
off. It corrects the link as a Luenberger observer does, so that the residual is an innovation: what is new in a sample.
A link that has play would otherwise bounce on by itself: where it meets its motor next, no record could tell.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import casadi as ca

from stribeck.model.balance import Balance
from stribeck.model.drive import Drive
from stribeck.model.sensitivity import Sensitivity

SLOW = 1e-3  # rad a sample: what swings less is as good as loose
DAMPING = 0.7  # of critical, up to which the correction damps a link's ringing


def observed(balance: Balance, sample_time: float, now: Drive, carried: Sensitivity, moved: Sensitivity) -> Sensitivity:
    """Return states one sample later (``moved``), corrected by the residual of the sample before (``carried``).

    Links that ring faster than samples show are left alone; a stand that yields with the motor is corrected the less,
    the heavier it is against its arm. Where a link meets its motor at faces, it is corrected as if they touched: within
    the play it nears the face that its motor seems to feel.

    Parameters
    ----------
    balance : Balance
    sample_time : float
        s.
    now : Drive
        At the sample before.
    carried : Sensitivity
        States at the sample before, the symbols of the path.
    moved : Sensitivity
        The same states one sample later.
    """
    path, x, p = balance.path, carried.states, balance.path.p
    if not path.flexible:
        return moved
    residual, _ = balance.residual(now, x, settled=False)
    correction = ca.SX.zeros(x.numel())
    mobility, bent = balance.links(now, x).mobility, balance.motors(now).deflections(x[: 2 * len(path.flexible)])
    for i, joint in enumerate(path.flexible):
        stiffness, damping = _touching(balance, i, bent)
        stiffness = ca.fmax(stiffness, SLOW**2 / (mobility[i, i] * sample_time**2))
        frequency = ca.sqrt(stiffness * mobility[i, i])
        own = 0.5 * damping * mobility[i, i] / frequency  # of critical: what does not ring needs none
        z = sample_time * frequency
        part = 2.0 * ca.fmax(DAMPING - own, 0.0) * z / (1.0 + z**4)
        scale = path.command_scale(joint, now.position[joint])
        correction[2 * i] = -part / stiffness * residual[joint] * scale
    columns = ca.jacobian(correction, p)[:, list(carried.parameters)]
    columns += ca.mtimes(ca.jacobian(correction, x), carried.columns)
    return replace(moved, states=moved.states + correction, columns=moved.columns + columns)


def _touching(balance: Balance, i: int, bent: Any) -> tuple[Any, Any]:
    """Return stiffness, N m/rad, and damping, N m s/rad, of the i-th compliance at deflections and rates (2 L, 1)."""
    path, count = balance.path, len(balance.path.flexible)
    k, effect = path.transmission(path.flexible[i])  # type: ignore[misc]
    deflection, rate = ca.SX.sym("deflection"), ca.SX.sym("rate")
    both = effect.touching(deflection, rate, path.parameters(k))
    there = ca.vertcat(bent[i], bent[count + i])
    return tuple(ca.substitute(ca.vertcat(*both), ca.vertcat(deflection, rate), there)[row] for row in range(2))
