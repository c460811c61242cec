"""A run on a uniform clock: left as it is where it can be, resampled where jitter or missing samples need it."""

from __future__ import annotations

import dataclasses
import itertools
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from stribeck.errors import InputError
from stribeck.run import Run
from stribeck.run.held import mean_of_held
from stribeck.run.reading import as_read
from stribeck.run.values import Floats

TOLERATED_JITTER = 1e-3
"""Departure of a sample from a uniform clock, in steps, up to which the samples are left as they are."""

_ROUNDING = 1e-9  # steps; such a clock is uniform already
_ROUGHER = 2.0  # squared third differences at the times that are stamped, over those at even ones: the stamps are off

LONG_AGO = 1e6
"""Times that began longer ago, s, are told by so much less: seconds since 1970 have too few digits left for a step."""

GAP_STEPS = 5.0
"""A step longer than this many median steps is a gap: what is interpolated across it is marked."""


def uniform(run: Run, since: float | None = None) -> tuple[Run, tuple[str, ...]]:
    """Put a run on a uniform clock.

    Positions are made those of an encoder that counts on and is read in every row (`as_read`), and whole millions of
    seconds are taken off the times. Where the clock is uniform to 1e-3 of its step, only `t` is replaced, if need be;
    so it is where the motion is smoother that way, as where samples are taken evenly but stamped when they arrive.
    Elsewhere the run is resampled: position by cubic splines between gaps (linear across them); commanded torque as the
    time average, over each new step, of the torque held between the recorded samples, so that its impulse is kept, and
    what such a mean lacks of a held command is told along (`stribeck.run.held`); all else linearly.

    Parameters
    ----------
    run : Run
        With N samples and increasing `t`.
    since : float or None
        When the first of several recordings began, s, for all of them to count from the same millions; None: this one.

    Returns
    -------
    run : Run
        With M samples at a constant step, the first at its own time; `gaps` (M,) marks samples that lie across
        missing ones, and is None when there are none.
    notes : tuple of str
        What was done, for the reader of a report; empty when nothing was.

    Raises
    ------
    InputError
        When more of the recording is missing than there is.
    """
    run, said = as_read(run)
    origin = LONG_AGO * math.trunc((run.t[0] if since is None else since) / LONG_AGO)
    if origin:
        run = dataclasses.replace(run, t=run.t - origin)
        said = (*said, f"{run.name}: times are counted from {origin:.0f} s on")
    even, done = _even(run)
    return even, (*said, *done)


def _even(run: Run) -> tuple[Run, tuple[str, ...]]:
    """Return the run on a uniform clock, and what was done to its times."""
    step, fitted, counts = _clock(run.t)
    if fitted is None:
        return _stamped(run, step)
    even = dataclasses.replace(run, t=fitted)
    off = np.abs(run.t - fitted).max() / step
    if (counts == 1.0).all():
        if off <= _ROUNDING:
            return run, ()
        if off <= TOLERATED_JITTER:
            return even, ()
    stamped, notes = _stamped(run, step)
    if off <= TOLERATED_JITTER:
        return stamped, notes
    even, missing = (even, ()) if (counts == 1.0).all() else _stamped(even, step)
    if _rougher(stamped.q, even.q) < _ROUGHER:
        return stamped, notes
    note = (
        f"{run.name}: samples taken as {1e3 * step:.6g} ms apart, which makes the motion smooth; their time stamps are "
        f"up to {1e3 * step * off:.3g} ms off"
    )
    return even, (note, *missing)


def _stamped(run: Run, step: float) -> tuple[Run, tuple[str, ...]]:
    """Return the run resampled at constant steps, as its time stamps tell of it, and what was done."""
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


def _rougher(first: Floats, second: Floats) -> float:
    """Return how much rougher the first of two records (N, n) is: its squared third differences over the other's.

    Joints count by how much the two differ there: one that rests says nothing.
    """
    rough = [np.mean(np.diff(record, 3, axis=0) ** 2, axis=0) for record in (first, second)]
    least = np.minimum(*rough) + np.finfo(float).tiny
    one, other = (float(np.sum(each / least)) for each in rough)
    return one / max(other, np.finfo(float).tiny)


def _clock(t: Floats) -> tuple[float, Floats | None, Floats]:
    """Fit ``t = a + h k`` with whole k; return h, the fitted times (None where jitter adds up) and the steps of k.

    A clock that is uniform but printed with few digits gets its true step this way, which the median step misses.
    """
    steps = np.diff(t)
    median = float(np.median(steps))
    counts = np.maximum(1.0, np.rint(steps / median))
    one_by_one = np.concatenate([[0.0], np.cumsum(counts)])
    return _line(t, one_by_one) or _line(t, _counted(t, median)) or (median, None, counts)


def _line(t: Floats, k: Floats) -> tuple[float, Floats, Floats] | None:
    """Return the step, the times and the steps of whole numbers k for which a line fits t; None where it does not."""
    centred = k - k.mean()
    step = float(centred @ (t - t.mean()) / (centred @ centred))
    fitted = t.mean() + step * centred
    steps = np.diff(k)
    return (step, fitted, steps) if np.abs(t - fitted).max() <= 0.5 * step and (steps > 0.0).all() else None


def _counted(t: Floats, step: float) -> Floats:
    """Return at which of equal steps, of about this length, the times (N,) lie, whole numbers.

    From single steps they cannot be counted where stamps are off by a quarter of one: two that are make one of one and
    a half. Over more of them the step is known better, and over more again counted with that.
    """
    apart = 4
    while apart <= len(t) // 2:
        taken = t[apart:] - t[:-apart]
        step = float(np.median(taken / np.maximum(np.rint(taken / step), 1.0)))
        apart *= 2
    place = (t - t[0]) / step
    phase = float(np.angle(np.mean(np.exp(2j * np.pi * place)))) / (2.0 * np.pi)
    count = np.rint(place - phase)
    centred = count - count.mean()  # a line through all of them: the ends are counted by the same step as the middle
    slope = float(centred @ place / (centred @ centred))
    return np.asarray(np.rint((place - place.mean()) / slope + count.mean()))


def _resample(run: Run, t: Floats, step: float, long: NDArray[np.intp]) -> Run:
    gaps = np.zeros(len(t), dtype=bool)
    near = TOLERATED_JITTER * step  # so that rounding does not mark the samples at the gap's own edges
    for i in long:
        gaps[np.searchsorted(t, run.t[i] + near, "right") : np.searchsorted(t, run.t[i + 1] - near, "left")] = True
    linear: dict[str, Any] = {}
    for key in ("dq", "q_ref", "dq_ref", "tau_meas", "temperature", "droop"):
        values = getattr(run, key)
        if values is not None:
            linear[key] = np.column_stack([np.interp(t, run.t, column) for column in values.T])
    tau, droop = mean_of_held(run.t, run.tau, np.append(t, t[-1] + step))
    return dataclasses.replace(
        run,
        t=t,
        q=np.column_stack([_smooth(run.t, column, t, long) for column in run.q.T]),
        tau=tau,
        extra=None,  # of unknown meaning, so there is no right way to interpolate them
        gaps=gaps if len(long) else None,
        **{**linear, "droop": droop + linear.get("droop", 0.0)},
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
