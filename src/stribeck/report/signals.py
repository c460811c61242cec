"""Choosing and thinning what is drawn of a recording; nothing here changes a value that is stated in words."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stribeck.gap.result import Diagnosis, Trace

Window = tuple[Trace, slice]


def torque_scale(diagnosis: Diagnosis) -> np.ndarray:
    """Return the torque (n,) that makes joints comparable: the noise floor, or the re-tuned gap without one."""
    for name in ("noise_floor", "retuned"):
        values = np.array([_stage_torque(diagnosis, name).get(joint, np.nan) for joint in diagnosis.joints])
        if np.all(np.isfinite(values) & (values > 0)):
            return values
    return np.ones(len(diagnosis.joints))


def _stage_torque(diagnosis: Diagnosis, name: str) -> Mapping[str, float]:
    return next((stage.torque for stage in diagnosis.stages if stage.stage == name), {})


def telling_window(diagnosis: Diagnosis, seconds: float = 3.0) -> Window | None:
    """Return the run and the stretch of it where the re-tuned model's residual is largest, all joints scaled.

    Parameters
    ----------
    diagnosis : Diagnosis
        Its ``traces`` are searched; None is returned where there are none.
    seconds : float
        Length of the stretch, s; a shorter run is taken whole.
    """
    scale = torque_scale(diagnosis)
    best: tuple[float, Window] | None = None
    for trace in diagnosis.traces:
        if len(trace.time) < 2:
            continue
        energy = np.nansum(((trace.measured - trace.retuned) / scale) ** 2, axis=1)
        total = np.concatenate(([0.0], np.cumsum(energy)))
        end = np.searchsorted(trace.time, trace.time + seconds, side="right")
        start = np.flatnonzero(trace.time + 0.98 * seconds <= trace.time[-1])
        start = start if len(start) else np.array([0])
        held = total[end[start]] - total[start]
        near = start[held >= 0.98 * held.max()]  # as good, and its events not at the edge
        k = near[len(near) // 2]
        score = float(total[end[k]] - total[k])
        if best is None or score > best[0]:
            best = score, (trace, slice(int(k), int(end[k])))
    return best[1] if best else None


def with_breaks(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return time (M,) and values (M,) with a NaN where the recording jumps, so that no line is drawn across."""
    step = np.diff(time)
    jumps = np.flatnonzero(step > 5.0 * np.median(step)) + 1 if len(step) else np.array([], dtype=int)
    return np.insert(time, jumps, time[jumps - 1]), np.insert(values, jumps, np.nan)


def thin(time: np.ndarray, values: np.ndarray, limit: int = 3000) -> tuple[np.ndarray, np.ndarray]:
    """Return at most ``limit`` points with the same outline: the lowest and highest value of each stretch."""
    time, values = with_breaks(time, values)
    if len(time) <= limit:
        return time, values
    edges = np.linspace(0, len(time), limit // 2 + 1).astype(int)[:-1]
    outline = np.column_stack((np.fmin.reduceat(values, edges), np.fmax.reduceat(values, edges)))
    return np.repeat(time[edges], 2), outline.ravel()


def sampled(count: int, limit: int = 4000) -> slice:
    """Return every k-th of ``count`` samples, at most ``limit``."""
    return slice(None, None, max(1, -(-count // limit)))


def stacked(diagnosis: Diagnosis, name: str) -> np.ndarray:
    """Return one signal of all held-out runs, (sum of M, n)."""
    return np.concatenate([np.asarray(getattr(trace, name)) for trace in diagnosis.traces])


def telling_family(diagnosis: Diagnosis) -> str:
    """Return "position" where the residual depends on position more than on velocity, else "velocity".

    Compared by how much more of the squared residual than of the time a single region holds.
    """
    position, velocity = 0.0, 0.0
    for region in diagnosis.regions:
        excess = region.share.value - region.time_share
        if region.family == "position":
            position = max(position, excess)
        elif region.family in ("velocity", "motion", "direction"):
            velocity = max(velocity, excess)
    return "position" if position > velocity else "velocity"
