"""The linear part of the control law of `stribeck.simulate`, as a state space from recorded motion to command."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stribeck.arm import Arm
from stribeck.simulate.axis import start_position
from stribeck.simulate.engine import Engine, path_of
from stribeck.simulate.loop import JointLoop, Loop

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Controller:
    """x+ = A x + B [q, dq], u = C x + D [q, dq]; x+ is the derivative for a continuous controller."""

    a: Floats
    b: Floats
    c: Floats
    d: Floats


def derivative_gain(entry: JointLoop, kp: float, inertia: float) -> float:
    """Return kv, N m s/rad; critical damping, 2 sqrt(kp J), where the loop leaves it open: J is the `tuned_inertia`."""
    return 2.0 * math.sqrt(kp * inertia) if entry.kv is None else entry.kv


def tuned_inertia(arm: Arm, loop: Loop) -> Floats:
    """Return the inertia (n,) by which a loop's controllers set critical damping, kg m^2: where the loop starts."""
    return Engine(path_of(arm)).moved_inertia(start_position(arm, loop))


def controller(entry: JointLoop, kp: float, kv: float, sample_time: float) -> Controller:
    """Return the PID law of one joint about a reference of zero.

    Parameters
    ----------
    entry : JointLoop
        For everything but the gains kp and kv.
    kp, kv : float
        N m/rad and N m s/rad.
    sample_time : float
        s; 0 is a continuous controller, in which a finite difference is the velocity itself.
    """
    return _sampled(entry, kp, kv, sample_time) if sample_time > 0.0 else _continuous(entry, kp, kv)


def _sampled(entry: JointLoop, kp: float, kv: float, step: float) -> Controller:
    """States: the last position, the filtered velocity, the integral of position up to the sample before."""
    gain = -math.expm1(-step / entry.velocity_filter) if entry.velocity_filter > 0.0 else 1.0
    raw_x = np.array([0.0, 0.0, 0.0]) if entry.velocity == "true" else np.array([-1.0 / step, 0.0, 0.0])
    raw_y = np.array([0.0, 1.0]) if entry.velocity == "true" else np.array([1.0 / step, 0.0])
    velocity_x = gain * raw_x + np.array([0.0, 1.0 - gain, 0.0])
    velocity_y = gain * raw_y
    a = np.stack([np.zeros(3), velocity_x, np.array([0.0, 0.0, 1.0])])
    b = np.stack([np.array([1.0, 0.0]), velocity_y, np.array([step, 0.0])])
    c = -kv * velocity_x - np.array([0.0, 0.0, entry.ki])
    d = -kv * velocity_y - np.array([kp, 0.0])
    used = [entry.velocity != "true", gain != 1.0, entry.ki > 0.0]
    return Controller(a[np.ix_(used, used)], b[used], c[used][None], d[None])


def _continuous(entry: JointLoop, kp: float, kv: float) -> Controller:
    """States: the filtered velocity and the integral of position."""
    rate = 1.0 / entry.velocity_filter if entry.velocity_filter > 0.0 else 0.0
    a = np.array([[-rate, 0.0], [0.0, 0.0]])
    b = np.array([[0.0, rate], [1.0, 0.0]])
    c = np.array([-kv if rate else 0.0, -entry.ki])
    d = np.array([-kp, 0.0 if rate else -kv])
    used = [rate > 0.0, entry.ki > 0.0]
    return Controller(a[np.ix_(used, used)], b[used], c[used][None], d[None])
