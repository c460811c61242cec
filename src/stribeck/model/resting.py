"""Bristles of joints at rest, which hold whatever torque there is.

A bristle's torque is stiffness times a way of some hundred micrometres, of which encoder and filters miss a part at
every stop. Where a joint then rests, a law that only adds up its motion would carry that error on until it slides
again. What a bristle holds at rest is known better from the torque: it is all that is left, up to the friction level,
as it is of a contact that does not give.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import casadi as ca

from stribeck.model.balance import Balance
from stribeck.model.drive import Drive
from stribeck.model.path import SignalPath
from stribeck.model.sensitivity import Sensitivity

SETTLES = 0.1  # s, in which a bristle at rest comes to hold what is left


def resting(path: SignalPath) -> tuple[int, ...]:
    """Return the joints whose bristle is told the torque at rest: those whose link moves with the motor.

    Behind a compliance the torque that is left already tells where the link is.
    """
    return tuple(j for j in range(path.n) if path.bristle(j) is not None and j not in path.flexible)


def begun(balance: Balance, now: Drive, states: Any) -> Any:
    """Return states (nx, 1) with which a recording starts, with its bristles told the torque.

    An arm that waits for its first motion is held by what the last one bent, whatever that was.

    Parameters
    ----------
    balance : Balance
    now : Drive
        At the first sample.
    states : casadi.SX (nx, 1)
        With bristles that hold nothing.
    """
    path = balance.path
    joints = resting(path)
    if not joints:
        return states
    residual, _ = balance.residual(now, states, settled=False)
    signals, _ = balance.signals(now, states)
    start = ca.SX(states)
    for j in joints:
        k, effect = path.bristle(j)  # type: ignore[misc]
        most = path.present_level(j, signals[j], states)
        left = residual[j] * path.command_scale(j, now.position[j]) * path.torque_left(j, signals[j], states)
        # without what damps a bristle that bends: where the joint slides already, it does not
        left += effect.bristle_torque(most, signals[j], path.states(k, states), path.parameters(k))
        held = ca.fmin(ca.fmax(left, -most), most)
        for name, torque in effect.bristle_holding(held, most).items():
            start[path.state_index(f"{k}.{name}")] = torque
    return start


def rested(balance: Balance, sample_time: float, now: Drive, carried: Sensitivity, moved: Sensitivity) -> Sensitivity:
    """Return states one sample later (``moved``), with the bristles of joints that rested at ``carried`` corrected.

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
    joints = resting(path)
    if not joints:
        return moved
    residual, _ = balance.residual(now, x, settled=False)
    signals, _ = balance.signals(now, x)
    part = -ca.expm1(-sample_time / SETTLES)
    correction = ca.SX.zeros(x.numel())
    for j in joints:
        k, effect = path.bristle(j)  # type: ignore[misc]
        rows = [path.state_index(f"{k}.{name}") for name in effect.states]
        held = ca.sum1(x[rows])
        most = ca.fmax(path.present_level(j, signals[j], x), ca.fabs(held))
        left = residual[j] * path.command_scale(j, now.position[j]) * path.torque_left(j, signals[j], x)
        holds = ca.fmin(ca.fmax(held + (1.0 - now.sliding[j]) * part * left, -most), most)
        for row, share in zip(rows, effect.bristle_shares(), strict=True):
            correction[row] = share * (holds - held)
    columns = ca.jacobian(correction, p)[:, list(carried.parameters)]
    columns += ca.mtimes(ca.jacobian(correction, x), carried.columns)
    return replace(moved, states=moved.states + correction, columns=moved.columns + columns)
