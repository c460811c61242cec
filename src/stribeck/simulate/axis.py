"""The runtime's view of a loop: one C structure a joint."""

from __future__ import annotations

import ctypes
import math

import numpy as np
from numpy.typing import NDArray

from stribeck.arm import Arm
from stribeck.arm.values import Joint
from stribeck.mirrored import check_names, check_structure
from stribeck.simulate.loop import JointLoop, Loop, Reference

Floats = NDArray[np.float64]

KINDS = ("none", "feedforward", "feedback", "adaptive", "robust", "dither")
AT_ZERO = ("zero", "hold", "error_sign", "set_valued")
COURSES = ("line", "sine", "steps", "curve")
_LINE, _SINE, _STEPS, _CURVE = range(len(COURSES))

_D, _I = ctypes.c_double, ctypes.c_int


class Axis(ctypes.Structure):
    """One joint's part of the loop, as declared in ``control.h``."""

    _fields_ = [
        *[(name, _D) for name in ("kp", "kv", "ki", "inertia", "filter", "lag", "resolution", "limit")],
        *[(name, _D) for name in ("ratio", "dead_band", "slope", "leakage", "inner", "amplitude", "omega")],
        ("gain", _D * 3),
        ("friction", _D * 8),
        ("reference", _D * 4),
        ("table", ctypes.c_void_p),
        ("knots", ctypes.c_longlong),
        *[(name, _I) for name in ("controlled", "true_velocity", "kind", "at_zero", "reference_kind", "delay")],
    ]


MEMORY = np.dtype([*((name, float) for name in ("last", "filtered", "integral", "held")), ("theta", float, 3)])
"""What a sampled controller remembers of a joint, as declared in ``control.h``."""


def check_mirrored(library: ctypes.CDLL) -> None:
    """Raise `StribeckError` where a library's structures of a joint, or its laws, are not those of this module."""
    check_structure(library, "sb_axis", Axis)
    check_structure(library, "sb_memory", MEMORY)
    check_names(library, "sb_kinds", KINDS)
    check_names(library, "sb_at_zero", AT_ZERO)
    check_names(library, "sb_courses", COURSES)


def axes_of(arm: Arm, loop: Loop, inertia: Floats) -> tuple[ctypes.Array[Axis], list[Floats]]:
    """Return the structures of all joints, and the tables that they point to, which must be kept alive.

    Parameters
    ----------
    arm : Arm
    loop : Loop
    inertia : array (n,)
        What each joint moves with the others held, for critical damping, kg m^2.
    """
    axes = (Axis * arm.n)()
    kept: list[Floats] = []
    for entry in loop.joints:
        j = arm.names.index(entry.joint)
        table = _table(entry.reference)
        kept.append(table)
        _fill(axes[j], entry, arm.joints[j], float(inertia[j]), table)
    return axes, kept


def _fill(axis: Axis, entry: JointLoop, joint: Joint, inertia: float, table: Floats) -> None:
    c = entry.compensation
    axis.kp, axis.ki, axis.inertia = entry.kp, entry.ki, entry.inertia
    axis.kv = 2.0 * math.sqrt(entry.kp * inertia) if entry.kv is None else entry.kv
    axis.filter, axis.lag, axis.resolution = entry.velocity_filter, entry.actuator_lag, entry.encoder_resolution
    axis.limit = math.inf if joint.torque_limit is None else joint.torque_limit
    axis.ratio, axis.dead_band, axis.slope, axis.leakage = c.ratio, c.dead_band, c.slope, c.leakage
    axis.inner, axis.amplitude, axis.omega = c.inner, c.amplitude, 2.0 * math.pi * c.frequency
    axis.gain[:] = c.gain
    axis.friction[:] = [getattr(side, key) for side in (joint.friction, joint.backward) for key in _CONSTANTS]
    axis.kind, axis.at_zero = KINDS.index(c.kind), AT_ZERO.index(c.at_zero)
    axis.controlled, axis.true_velocity, axis.delay = 1, int(entry.velocity == "true"), entry.delay_samples
    axis.reference_kind, axis.reference[:] = _course(entry)
    axis.table, axis.knots = table.ctypes.data, len(table)


_CONSTANTS = ("C0", "C1", "C2", "alpha")


def _course(entry: JointLoop) -> tuple[int, tuple[float, float, float, float]]:
    r = entry.reference
    if r.kind == "ramp":
        return _LINE, (entry.start, r.velocity, 0.0, 0.0)
    if r.kind == "sine":
        return _SINE, (entry.start, r.amplitude, 2.0 * math.pi * r.frequency, r.phase)
    if r.kind == "regulate":
        return _LINE, (entry.start, 0.0, 0.0, 0.0)
    if r.kind == "steps":
        return _STEPS, (entry.start, 0.0, 0.0, 0.0)
    return _CURVE, (r.values[0], 0.0, 0.0, 0.0)


def _table(reference: Reference) -> Floats:
    """Return the knots (K, 3) of steps or of a followed run: time, position, velocity."""
    if reference.kind not in ("steps", "file"):
        return np.zeros((0, 3))
    times, values = np.array(reference.times), np.array(reference.values)
    rate = np.zeros_like(values)
    if reference.kind == "file" and len(values) > 1:
        rate = np.gradient(values, times, edge_order=2 if len(values) > 2 else 1)
    return np.ascontiguousarray(np.stack([times, values, rate], axis=1))


def start_position(arm: Arm, loop: Loop) -> Floats:
    """Return the recorded position (n,) from which the loop starts, rad."""
    q = np.array([loop.clamp.get(name, 0.0) for name in arm.names])
    for entry in loop.joints:
        r, j = entry.reference, arm.names.index(entry.joint)
        q[j] = entry.start - r.error_at_start
        if r.kind == "sine":
            q[j] += r.amplitude * math.sin(r.phase)
        elif r.kind == "file":
            q[j] = r.values[0]
    return q
