"""Cells of a map by a kernel of their own: one joint, Tustin friction, PID with compensation, thousands a second."""

from __future__ import annotations

import ctypes
import math
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import numpy as np
from numpy.typing import NDArray

from stribeck.compiler import build, load
from stribeck.loop.cycle import VERDICTS
from stribeck.loop.exact.rounds import Rounds
from stribeck.loop.exact.starts import LARGE, SMALL, moving_error
from stribeck.loop.maps.grid import Axes
from stribeck.mirrored import check_names, check_structure
from stribeck.simulate.axis import AT_ZERO
from stribeck.simulate.engine import pointer

Floats = NDArray[np.float64]

KINDS = ("none", "feedforward", "feedback")  # those of `axis.KINDS` that the kernel has
_SETTINGS = (
    "inertia", "kp", "kv", "ki", "filter", "lag", "limit", "ratio", "dead_band", "rate", "sample", "delay",
)  # fmt: skip
CELL = np.dtype(
    [
        *((name, float) for name in _SETTINGS),
        ("friction", float, 8),
        *((name, float) for name in ("kind", "at_zero", "true_velocity")),
        ("starts", float, 6),
    ]
)
"""As declared in ``cells.h``."""
_SETS = {"k": "ratio", "kp": "kp", "kv": "kv", "ki": "ki", "delay": "delay", "dead_band": "dead_band",
         "velocity_filter": "filter", "actuator_lag": "lag", "velocity": "rate"}  # fmt: skip


@dataclass(frozen=True)
class Template:
    """What all cells of a map share.

    Attributes
    ----------
    cell : array () of `CELL`
    critical : bool
        Whether kv is that of critical damping wherever the grid does not set it.
    error : float
        The loop's own start: reference less position, rad.
    """

    cell: np.ndarray
    critical: bool
    error: float


def fits(rounds: Rounds, joint: str) -> str:
    """Return why the kernel cannot take this loop; empty where it can."""
    entry = rounds.entry(joint)
    if len(rounds.loop.joints) > 1:
        return "more than one joint is controlled"
    if rounds.engine.size > 2 * rounds.n or rounds.engine.path.placed:
        return "the arm has effects"
    if any(rounds.arm.gravity):
        return "the arm feels gravity"
    if entry.compensation.kind not in KINDS:
        return f"the compensation is {entry.compensation.kind}"
    if len(rounds.given.joints[0].reference.within(rounds.given.duration).times) > 1:
        return "the reference steps more than once"
    if entry.encoder_noise > 0.0 or entry.encoder_resolution > 0.0:
        return "the encoder has noise or steps"
    return ""


def template_of(rounds: Rounds, joint: str) -> Template:
    """Return what all cells of a map over this joint's loop share."""
    j, entry = rounds.index(joint), rounds.entry(joint)
    axis, cell = rounds.axes[j], np.zeros((), CELL)
    same = ("kp", "kv", "ki", "filter", "lag", "limit", "ratio", "dead_band", "delay", "at_zero", "true_velocity")
    for name in same:
        cell[name] = getattr(axis, name)
    cell["inertia"], cell["sample"], cell["rate"] = rounds.inertia[j], rounds.loop.sample_time, rounds.rate(j)
    cell["kind"] = KINDS.index(entry.compensation.kind)
    cell["friction"] = axis.friction[:]
    return Template(cell, entry.kv is None, entry.reference.error_at_start)


def cells_of(template: Template, axes: Axes, first: int, last: int) -> np.ndarray:
    """Return the cells first .. last - 1 of a grid."""
    cells, settings = np.repeat(template.cell, last - first), axes.settings(first, last)
    for name, values in settings.items():
        if name in _SETS:
            cells[_SETS[name]] = values
    if "zeta" in settings or (template.critical and "kv" not in settings):
        cells["kv"] = 2.0 * settings.get("zeta", 1.0) * np.sqrt(cells["kp"] * cells["inertia"])
    _set_starts(cells, template.error)
    return cells


def _set_starts(cells: np.ndarray, error: float) -> None:
    """Set the starts of every cell, the same as `stribeck.loop.exact.starts` gives."""
    ahead, behind = cells["friction"][:, :4].T, cells["friction"][:, 4:].T
    forward, backward = ahead[0] + ahead[1], behind[0] + behind[1]
    size = moving_error(np.maximum(forward, backward) / cells["kp"])
    ratio = np.where(cells["kind"] == 2, cells["ratio"], 0.0)
    ramp, rate = cells["rate"] != 0.0, cells["rate"]
    starts = [np.full(len(cells), v) for v in (error, 0.0, math.nan, 0.0, 0.0, 0.0)]
    starts[2] = np.where(ramp, math.nan, LARGE * np.maximum(1.0, ratio) * size)
    c0, c1, c2, alpha = np.where(rate < 0.0, behind, ahead)
    level = c0 + c1 * np.exp(-np.abs(rate) / alpha) + c2 * np.abs(rate)
    share = np.where(cells["kind"] == 0, 0.0, cells["ratio"])
    steady = np.sign(rate) * (1.0 - share) * level / cells["kp"]
    starts[4], starts[5] = np.where(ramp, 1.001 * steady, SMALL * size), np.where(ramp, rate, 0.0)
    cells["starts"] = np.stack(starts, axis=1)


@cache
def kernel() -> ctypes.CDLL:
    """Return the compiled kernel."""
    library = load(build((files("stribeck.loop.maps") / "c" / "cells.h").read_text(encoding="utf-8")))
    check_structure(library, "cell", CELL)
    check_names(library, "kinds", KINDS)
    check_names(library, "at_zero", AT_ZERO)
    check_names(library, "verdicts", VERDICTS)
    return library


def run_cells(template: Template, axes: Axes, first: int, last: int) -> tuple[NDArray[np.int8], Floats]:
    """Return verdict codes (M,), and amplitude (rad), period (s) and share of time stuck (M, 3), of some cells."""
    cells = cells_of(template, axes, first, last)
    codes, sizes = np.zeros(len(cells), np.int8), np.full((len(cells), 3), np.nan)
    kernel().sb_cells(pointer(cells), ctypes.c_longlong(len(cells)), pointer(codes), pointer(sizes))
    return codes, sizes
