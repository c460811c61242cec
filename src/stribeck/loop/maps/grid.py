"""The grid of a map: which settings it varies, and the loop of any one of its cells."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stribeck.errors import InputError
from stribeck.simulate import JointLoop, Loop, Reference

Floats = NDArray[np.float64]
SETTINGS = ("k", "kp", "zeta", "kv", "ki", "delay", "dead_band", "velocity_filter", "actuator_lag", "velocity")
_POSITIVE = ("kp",)
_LONGEST_DELAY = 1000  # samples


@dataclass(frozen=True)
class Axes:
    """The axes of a grid, in order.

    Attributes
    ----------
    names : tuple of str
        ``k`` (compensation over true friction), ``kp`` (N m/rad), ``zeta`` (kv = 2 zeta sqrt(kp J)), ``kv``, ``ki``,
        ``delay`` (samples), ``dead_band`` (rad/s), ``velocity_filter``, ``actuator_lag`` (s), ``velocity`` (of a
        ramp, rad/s).
    values : tuple of arrays
    """

    names: tuple[str, ...]
    values: tuple[Floats, ...]

    @property
    def shape(self) -> tuple[int, ...]:
        """Cells along each axis."""
        return tuple(len(v) for v in self.values)

    @property
    def size(self) -> int:
        """Number of cells."""
        return math.prod(self.shape)

    def settings(self, first: int, last: int) -> dict[str, Floats]:
        """Return the settings of the cells first .. last - 1, in C order, one array each."""
        places = np.unravel_index(np.arange(first, last), self.shape)
        return {name: v[place] for name, v, place in zip(self.names, self.values, places, strict=True)}


def check_axes(axes: Mapping[str, Sequence[float] | Floats], loop: Loop) -> Axes:
    """Return the axes of a grid; raise `InputError` where one is unknown, empty, out of range or in contradiction."""
    if not axes:
        raise InputError("the map has no axis", "", f"give at least one of {', '.join(SETTINGS)}")
    kept = []
    for name, given in axes.items():
        values = np.asarray(given, dtype=float).ravel()
        if name not in SETTINGS:
            raise InputError("the map has no such axis", repr(name), f"take one of {', '.join(SETTINGS)}")
        if values.size == 0:
            raise InputError(f"the map's axis {name} is empty", "", "give at least one value")
        wrong = ~np.isfinite(values) | (values < 0.0) & (name != "velocity") | (values <= 0.0) & (name in _POSITIVE)
        if wrong.any():
            what = f"the map's axis {name} is out of range"
            raise InputError(
                what, f"{values[wrong][0]:g}", "give values above zero" if name in _POSITIVE else "at least 0"
            )
        kept.append(values)
    if "kv" in axes and "zeta" in axes:
        raise InputError("the map varies kv and zeta", "", "zeta says what kv is: keep one of them")
    if "delay" in axes:
        _check_delay(kept[list(axes).index("delay")], loop)
    return Axes(tuple(axes), tuple(kept))


def _check_delay(values: Floats, loop: Loop) -> None:
    if loop.sample_time == 0.0:
        raise InputError(
            "a delay in samples needs a sampled controller", "sample_time = 0", "give a sample_time above 0"
        )
    wrong = (values != np.round(values)) | (values > _LONGEST_DELAY)
    if wrong.any():
        do = f"give whole numbers of samples up to {_LONGEST_DELAY}"
        raise InputError("the map's axis delay is out of range", f"{values[wrong][0]:g}", do)


def loop_of_cell(loop: Loop, entry: JointLoop, inertia: float, cell: Mapping[str, float]) -> Loop:
    """Return the loop of one cell, from the map's own loop, the joint's part of it and its inertia (kg m^2)."""
    kp = cell.get("kp", entry.kp)
    kv = cell.get("kv", entry.kv)
    if "zeta" in cell:
        kv = 2.0 * cell["zeta"] * math.sqrt(kp * inertia)
    compensation = replace(
        entry.compensation,
        ratio=cell.get("k", entry.compensation.ratio),
        dead_band=cell.get("dead_band", entry.compensation.dead_band),
    )
    reference = Reference("ramp", velocity=cell["velocity"]) if "velocity" in cell else entry.reference
    changed = replace(
        entry,
        kp=kp,
        kv=kv,
        ki=cell.get("ki", entry.ki),
        delay_samples=int(cell.get("delay", entry.delay_samples)),
        velocity_filter=cell.get("velocity_filter", entry.velocity_filter),
        actuator_lag=cell.get("actuator_lag", entry.actuator_lag),
        compensation=compensation,
        reference=reference,
    )
    return replace(loop, joints=tuple(changed if other.joint == entry.joint else other for other in loop.joints))
