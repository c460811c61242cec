"""A run on a uniform clock: left as it is where it can be, resampled where jitter or missing samples need it."""

from __future__ import annotations

import dataclasses
import itertools
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from stribeck.errors import InputError
from stribeck.run import Run
from stribeck.run.values import Floats

TOLERATED_JITTER = 1e-3
"""Departure of a sample from a uniform clock, in steps, up to which the samples are left as they are."""

_ROUNDING = 1e-9  # steps; such a clock is uniform already

RESTING = 1e-12  # rad, up to which a record has not moved
LEAST_STEPS = 8  # of a record, that show a grid
NEAR = 0.125  # of a quantum: nearer to a grid lie few values of a record that is on none
UNEVEN = 0.1  # of its steps, after which a count goes on by more or less

GAP_STEPS = 5.0
"""A step longer than this many median steps is a gap: what is interpolated across it is marked."""


def uniform(run: Run) -> tuple[Run, tuple[str, ...]]:
    """Put a run on a uniform clock.

    Where the clock is uniform to 1e-3 of its step, only `t` is replaced, if need be. Elsewhere the run is
    resampled: position by cubic splines between gaps (linear across them); commanded torque as the time average,
    over each new step, of the torque held between the recorded samples, so that its impulse is kept; all else
    linearly.

    Parameters
    ----------
    run : Run
        With N samples and increasing `t`.

    Returns
    -------
    run : Run
        With M samples at a constant step, the first at the same time; `gaps` (M,) marks samples that lie across
        missing ones, and is None when there are none.
    notes : tuple of str
        What was done, for the reader of a report; empty when nothing was.

    Raises
    ------
    InputError
        When more of the recording is missing than there is.
    """
    step, fitted, counts = _clock(run.t)
    if fitted is not None and (counts == 1.0).all():
        jitter = np.abs(run.t - fitted).max() / step
        if jitter <= _ROUNDING:
            return run, ()
        if jitter <= TOLERATED_JITTER:
            return dataclasses.replace(run, t=fitted), ()
    steps = np.diff(run.t)
    m = int(np.floor((run.t[-1] - run.t[0]) / step * (1.0 + 1e-12))) + 1
    if m > 2 * len(run.t):
        i = int(steps.argmax())
        what = f"{run.name}: more samples are missing than were recorded; the longest gap follows t = {run.t[i]:g} s"
        raise InputError(what, f"{steps[i]:g} s", "split the recording there")
    t = run.t[0] + step * np.arange(m)
    long = np.flatnonzero(steps > GAP_STEPS * np.median(steps))
    notes = [
        f"{run.name}: resampled from {len(run.t)} samples with steps of {1e3 * steps.min():.4g} to "
        f"{1e3 * steps.max():.4g} ms to {m} samples with steps of {1e3 * step:.6g} ms"
    ]
    if len(long):
        worst = long[steps[long].argmax()]
        notes.append(
            f"{run.name}: {len(long)} gap{'s' if len(long) > 1 else ''} with {steps[long].sum():.4g} s missing in all; "
            f"the longest, {steps[worst]:.4g} s, follows t = {run.t[worst]:.6g} s"
        )
    return _resample(run, t, step, long), tuple(notes)


def _clock(t: Floats) -> tuple[float, Floats | None, Floats]:
    """Fit ``t = a + h k`` with whole k; return h, the fitted times (None where jitter adds up) and the steps of k.

    A clock that is uniform but printed with few digits gets its true step this way, which the median step misses.
    """
    steps = np.diff(t)
    median = float(np.median(steps))
    counts = np.maximum(1.0, np.rint(steps / median))
    k = np.concatenate([[0.0], np.cumsum(counts)])
    centred = k - k.mean()
    step = float(centred @ (t - t.mean()) / (centred @ centred))
    fitted = t.mean() + step * centred
    if np.abs(t - fitted).max() > 0.5 * step:
        return median, None, counts
    return step, fitted, counts


def _resample(run: Run, t: Floats, step: float, long: NDArray[np.intp]) -> Run:
    gaps = np.zeros(len(t), dtype=bool)
    near = TOLERATED_JITTER * step  # so that rounding does not mark the samples at the gap's own edges
    for i in long:
        gaps[np.searchsorted(t, run.t[i] + near, "right") : np.searchsorted(t, run.t[i + 1] - near, "left")] = True
    linear: dict[str, Any] = {}
    for key in ("dq", "q_ref", "dq_ref", "tau_meas", "temperature"):
        values = getattr(run, key)
        if values is not None:
            linear[key] = np.column_stack([np.interp(t, run.t, column) for column in values.T])
    return dataclasses.replace(
        run,
        t=t,
        q=np.column_stack([_smooth(run.t, column, t, long) for column in run.q.T]),
        tau=np.column_stack([_held(run.t, column, t, step) for column in run.tau.T]),
        extra=None,  # of unknown meaning, so there is no right way to interpolate them
        gaps=gaps if len(long) else None,
        **linear,
    )


def _smooth(t: Floats, values: Floats, new: Floats, long: NDArray[np.intp]) -> Floats:
    """Interpolate by one cubic spline for each stretch between gaps, and linearly across the gaps.

    One spline over all would swing out in the gaps and ring beside them.
    """
    result: Floats = np.interp(new, t, values)
    bounds = np.concatenate([[0], long + 1, [len(t)]])
    for first, last in itertools.pairwise(bounds):
        if last - first > 1:
            inside = slice(np.searchsorted(new, t[first], "left"), np.searchsorted(new, t[last - 1], "right"))
            result[inside] = CubicSpline(t[first:last], values[first:last])(new[inside])
    return result


def _held(t: Floats, values: Floats, new: Floats, step: float) -> Floats:
    """Average, over each new step, a signal that is held from one sample to the next (the last one without end)."""
    end = max(float(t[-1]), float(new[-1] + step)) + step
    knots = np.append(t, end)
    impulse = np.concatenate([[0.0], np.cumsum(values * np.diff(knots))])
    edges = np.append(new, new[-1] + step)
    return np.asarray(np.diff(np.interp(edges, knots, impulse)) / step)


def smallest_step(*records: np.ndarray) -> tuple[float, float]:
    """Return the quantum of some records (rad) and by how much it may be off; 0, 0 where they lie on no grid.

    A record that rests shows no grid, and says nothing against it. One that never moves slowly steps over many quanta
    at a time; of all values that it takes, some lie a quantum apart. Equal steps, sample after sample, are no grid but
    a constant speed: an encoder's count goes on now and then, or by one more or less.
    """
    moving = [record for record in records if np.ptp(record) > RESTING]
    if not moving:
        return 0.0, 0.0
    steps = np.concatenate([np.abs(np.diff(record)) for record in moving])
    apart = np.concatenate([np.diff(np.unique(record)) for record in moving])
    rounded, printed = (max(map(told, moving)) for told in (_rounded, _printed))
    if np.sum(steps > RESTING) < LEAST_STEPS:
        return 0.0, 0.0
    for gaps in (steps, apart):
        quantum, off = _fitted(moving, steps, float(np.quantile(gaps[gaps > RESTING], 0.01)))
        counted = np.round(steps / quantum)
        uneven = np.sum(np.diff(counted) != 0.0) > UNEVEN * np.sum(counted > 0.0)
        near = max(rounded, min(printed, NEAR * quantum))
        if np.mean(off > near) < 0.05 and uneven:
            return quantum, near
    return 0.0, 0.0


def _fitted(records: list[np.ndarray], steps: np.ndarray, quantum: float) -> tuple[float, np.ndarray]:
    """Return a quantum, fitted to the steps and then to all values, and how far these (M,) lie off its grid."""
    multiples = np.round(steps / quantum)
    quantum = float(multiples @ steps / (multiples @ multiples))
    values = np.concatenate([record - np.mean(record) for record in records])
    places = [np.round((record - record[0]) / quantum) for record in records]
    centred = np.concatenate([place - np.mean(place) for place in places])
    quantum = float(centred @ values / max(centred @ centred, 1.0))
    off = [record - quantum * place for record, place in zip(records, places, strict=True)]
    return quantum, np.abs(np.concatenate([one - np.median(one) for one in off]))


def _rounded(record: np.ndarray) -> float:
    """Return by how much a record's values may be rounded, rad: as printed with few digits, or in single precision."""
    for digits in range(3, 13):
        if np.all(np.abs(record - np.round(record, digits)) < 1e-14 + 4.0 * np.spacing(np.abs(record))):
            return float(0.6 * 10.0**-digits)
    return float(2.0 * np.max(np.abs(record)) * np.finfo(np.float32).eps)


def _printed(record: np.ndarray) -> float:
    """Return by how much a record's largest values may be rounded, rad, where all have as many significant digits."""
    values = np.abs(record[record != 0.0])
    first = np.floor(np.log10(values))
    for digits in range(3, 13):
        unit = 10.0 ** (first - digits + 1)
        if np.all(np.abs(values - unit * np.round(values / unit)) < 4.0 * np.spacing(values)):
            return float(0.6 * unit.max())
    return 0.0
