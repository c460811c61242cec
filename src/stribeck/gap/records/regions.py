"""Regions of a motion: reversals, rest, speeds, directions, places and loads, as masks over a residual's samples."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from stribeck.arm import unit_at
from stribeck.identify.conditioning import Conditioned

NEAR_REVERSAL = 0.08  # s
POSITION_BINS = 6


def analysis_signals(runs: Sequence[Conditioned]) -> dict[str, np.ndarray]:
    """Return position, velocity, acceleration and command (M, n) at the analysis samples, and time (M,).

    That is since the recording began, s, also where a run is a part of it.
    """
    out = {
        name: np.concatenate([getattr(run, name)[run.analysis_index] for run in runs])
        for name in ("position", "velocity", "acceleration", "stuck")
    }
    out["command"] = np.concatenate([run.filtered(run.command) for run in runs])
    out["time"] = np.concatenate([run.past.lead + run.time[run.analysis_index] - run.time[0] for run in runs])
    return out


def region_masks(runs: Sequence[Conditioned], joint: int, kind: str) -> dict[str, dict[str, np.ndarray]]:
    """Return family -> region -> mask (M,) over the analysis samples; the regions of a family partition them.

    Places are named in the unit of the joint's ``kind``.
    """
    s = analysis_signals(runs)
    velocity, motion = s["velocity"][:, joint], _motion(runs, s, joint)
    stuck = motion["stuck"]
    third = s["time"] / np.repeat([run.past.whole / 3.0 for run in runs], [len(run.analysis_index) for run in runs])
    families = {
        "motion": motion,
        "direction": {"forward": (velocity > 0) & ~stuck, "backward": (velocity <= 0) & ~stuck, "at rest": stuck},
        "position": _bins(s["position"][:, joint], unit_at("rad", kind)),
        "load": _thirds(np.abs(s["command"][:, joint]), "load"),
        "acceleration": _thirds(np.abs(s["acceleration"][:, joint]), "acceleration"),
        "time": {
            "first third of a run": third < 1.0,
            "middle third of a run": (third >= 1.0) & (third < 2.0),
            "last third of a run": third >= 2.0,
        },
    }
    return {family: _with_samples(masks) for family, masks in families.items()}


def motion_masks(runs: Sequence[Conditioned], joint: int) -> dict[str, np.ndarray]:
    """Return region -> mask (M,) of the family ``motion`` alone: at a reversal, stuck, or at which speed."""
    return _with_samples(_motion(runs, analysis_signals(runs), joint))


def _motion(runs: Sequence[Conditioned], s: dict[str, np.ndarray], joint: int) -> dict[str, np.ndarray]:
    near = np.concatenate([_near_reversal(run, joint) for run in runs])
    stuck = (s["stuck"][:, joint] > 0.5) & ~near
    moving = ~near & ~stuck
    speed = np.abs(s["velocity"][:, joint])
    low, high = np.quantile(speed[moving], [1 / 3, 2 / 3]) if moving.any() else (0.0, 0.0)
    return {
        "velocity reversal": near,
        "stuck": stuck,
        "low velocity": moving & (speed <= low),
        "medium velocity": moving & (speed > low) & (speed <= high),
        "high velocity": moving & (speed > high),
    }


def _with_samples(masks: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    return {region: mask for region, mask in masks.items() if mask.any()}


def _bins(position: np.ndarray, unit: str) -> dict[str, np.ndarray]:
    """Return equal bins of the travel, named with as many digits as tell them apart."""
    low, high = float(position.min()), float(position.max())
    step = (high - low) / POSITION_BINS
    if step <= 1e-12 * (1.0 + abs(low)):
        return {f"{low:.2f} {unit}": np.ones(len(position), dtype=bool)}
    digits = max(2, 1 - int(np.floor(np.log10(step))))
    edges = np.linspace(low, high, POSITION_BINS + 1)
    place = np.searchsorted(edges[1:-1], position, side="right")
    return {f"{a:.{digits}f} to {b:.{digits}f} {unit}": place == i for i, (a, b) in enumerate(pairwise(edges))}


def _thirds(size: np.ndarray, name: str) -> dict[str, np.ndarray]:
    low, high = np.quantile(size, [1 / 3, 2 / 3])
    return {
        f"low {name}": size <= low,
        f"medium {name}": (size > low) & (size <= high),
        f"high {name}": size > high,
    }


def _near_reversal(run: Conditioned, joint: int) -> np.ndarray:
    velocity, stuck = run.velocity[:, joint], run.stuck[:, joint] > 0.5
    sign = np.sign(np.where(stuck, 0.0, velocity))
    last = np.zeros_like(sign)
    seen = np.flatnonzero(sign != 0)
    if len(seen) == 0:
        return np.zeros(len(run.analysis_index), dtype=bool)
    last[seen] = sign[seen]
    turns = seen[1:][np.diff(sign[seen]) != 0]
    width = max(1, round(NEAR_REVERSAL / run.sample_time))
    near = np.zeros(len(velocity), dtype=bool)
    for i in turns:
        near[max(0, i - width) : i + width] = True
    return np.asarray(near[run.analysis_index])
