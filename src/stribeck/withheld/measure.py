"""How much torque a hidden effect is worth along a motion: the size of the gap that a diagnoser may hope to see."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cache

import numpy as np
from scipy.signal import butter, sosfiltfilt

from stribeck.arm import Arm
from stribeck.withheld.excitation import sliding
from stribeck.withheld.injections import Injection
from stribeck.withheld.motions import Motion
from stribeck.withheld.plant import Array, rigid_torque
from stribeck.withheld.recorder import Gains, record

CUT = 15.0  # Hz, of the low pass on the torque
EDGE = 0.3  # s, dropped at both ends
RATE = 500.0  # Hz
AT_REST = 0.1  # of the Stribeck velocity
STEP = 1e-4  # s; coarser than a recording


def torque_gap(
    arm: Arm, effects: Iterable[Injection], motions: Sequence[Motion], gains: Gains | None = None, rate: float = RATE
) -> tuple[Array, Array]:
    """Return the torque that the effects are worth, and the torque that moves the arm, both rms (motions, n), N m.

    The arm records the motions with the effects and without noise. The first number is the rms of the commanded
    torque less what the true arm without effects needs along the recorded motion, the second the rms of that need
    without gravity (inertia and friction), both below 15 Hz. While a joint sticks, friction takes any value up to
    break-away.

    Joints that a brake holds have neither.

    Parameters
    ----------
    arm : Arm
        The true one, without effects.
    effects : iterable of Injection
    motions : sequence of Motion
    gains : Gains or None
        Of the controller; its defaults where None.
    rate : float
        Of the recording, Hz.
    """
    missing, moving = [], []
    runs = record(arm, effects, motions, rate=rate, gains=gains, resolution=0.0, step=STEP)
    for run, motion in zip(runs, motions, strict=True):
        gap, need = residual_torque(arm, run.q, run.tau, rate)
        missing.append(_rms(gap) * driven(motion, arm.n))
        moving.append(_rms(need) * driven(motion, arm.n))
    return np.array(missing), np.array(moving)


def relative_gap(
    arm: Arm, effects: Iterable[Injection], motions: Sequence[Motion], gains: Gains | None = None, rate: float = RATE
) -> Array:
    """Return the share (n,) of the torque that moves the arm which the effects are worth.

    Every motion counts alike, but for those in which the joint has next to nothing to do.

    Parameters
    ----------
    arm : Arm
        The true one, without effects.
    effects : iterable of Injection
    motions : sequence of Motion
    gains : Gains or None
        Of the controller; its defaults where None.
    rate : float
        Of the recording, Hz.
    """
    missing, moving = torque_gap(arm, effects, motions, gains, rate)
    busy = moving > 0.1 * moving.max(axis=0)
    share = np.divide(missing, moving, out=np.zeros_like(moving), where=busy)
    return np.asarray(np.sqrt(np.sum(share**2, axis=0) / np.maximum(1, np.sum(busy, axis=0))))


def residual_torque(arm: Arm, q: Array, tau: Array, rate: float, cut: float = CUT) -> tuple[Array, Array]:
    """Return the torque (M, n) that a motion leaves unexplained, and what moves the arm, N m.

    Below the cut and without the edges.

    Parameters
    ----------
    arm : Arm
    q : array (N, n)
        Angles, rad.
    tau : array (N, n)
        Commands, held from sample to sample, N m.
    rate : float
        Hz.
    cut : float
        Of the low pass, Hz.
    """
    motion = derived(q, rate)
    need = _need(arm, motion, _command(tau))
    moving = need - rigid_torque(arm, q, 0.0 * q, 0.0 * q)
    return _inside(_command(tau) - need, rate, cut), _inside(moving, rate, cut)


def unexplained(arm: Arm, motion: tuple[Array, Array, Array], tau: Array, rate: float, cut: float = CUT) -> Array:
    """Return the torque (M, n) that a motion leaves unexplained, as `residual_torque`, N m.

    Parameters
    ----------
    arm : Arm
    motion : three arrays (N, n)
        As of `derived`: rad, rad/s, rad/s^2.
    tau : array (N, n)
        Commands, held from sample to sample, N m.
    rate : float
        Hz.
    cut : float
        Of the low pass, Hz.
    """
    command = _command(tau)
    return _inside(command - _need(arm, motion, command), rate, cut)


def driven(motion: Motion, n: int) -> Array:
    """Return 1 for each joint (n,) that a motion's commands drive, 0 for one that a brake holds at any torque."""
    return np.asarray(~np.isin(np.arange(n), motion.held), dtype=np.float64)


def derived(q: Array, rate: float) -> tuple[Array, Array, Array]:
    """Return angle, velocity and acceleration (N, n) of angles sampled at `rate`, Hz."""
    dq = np.gradient(q, 1.0 / rate, axis=0)
    return q, dq, np.gradient(dq, 1.0 / rate, axis=0)


def _command(tau: Array) -> Array:
    """Bring held commands to the time of the sample."""
    return np.asarray(0.5 * (tau + np.vstack([tau[:1], tau[:-1]])))


def _need(arm: Arm, motion: tuple[Array, Array, Array], command: Array) -> Array:
    """Return the torque (N, n) that the arm needs; while a joint sticks, friction is what the command leaves to it."""
    q, dq, ddq = motion
    rigid = rigid_torque(arm, q, dq, ddq)
    need = rigid + sliding(arm, dq)
    for k, joint in enumerate(arm.joints):
        top, bottom = joint.friction.C0 + joint.friction.C1, joint.backward.C0 + joint.backward.C1
        stuck = np.abs(dq[:, k]) < AT_REST * joint.friction.alpha
        held = np.clip(command[:, k] - rigid[:, k], -bottom, top)
        need[:, k] = np.where(stuck, rigid[:, k] + held, need[:, k])
    return need


def _inside(torque: Array, rate: float, cut: float) -> Array:
    edge = round(EDGE * rate)
    return np.asarray(sosfiltfilt(low_pass(rate, cut), torque, axis=0)[edge:-edge])


@cache  # its design takes longer than a run to filter
def low_pass(rate: float, cut: float) -> Array:
    """Return the second-order sections of the low pass below `cut`, Hz, at `rate`, Hz."""
    return np.asarray(butter(2, cut, fs=rate, output="sos"))


def _rms(x: Array) -> Array:
    return np.asarray(np.sqrt(np.mean(x**2, axis=0)))
