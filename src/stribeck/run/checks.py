"""Is the recording plausible? What is impossible is an error; what is doubtful becomes a warning."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stribeck.arm.units import unit_at
from stribeck.errors import InputError
from stribeck.run.turns import turned_on
from stribeck.run.values import Floats, Run

FEWEST_ROWS = 16
"""Fewer samples than this cannot carry a velocity and an acceleration, let alone a filter."""

_LARGEST_POSITION = 1000.0  # rad; 160 turns away from zero
_DOUBTFUL_POSITION = 25.0  # rad; four turns; +-180 given in degrees lies well above
_LARGEST_TORQUE = 1e6  # N m; twenty times the largest industrial arm's
_LARGEST_VELOCITY = 1e6  # rad/s; ten million turns a minute
_LATEST = 1e11  # s; three thousand years, whenever a clock began
_LONGEST_STEP = 0.2  # s; no arm is controlled at under 5 Hz, but clocks in milliseconds are common
_SHORTEST_STEP = 2e-5  # s; none is recorded at 50 kHz, but clocks in minutes or hours come to such steps


def check_time(t: Floats, path: Path, rows: NDArray[np.int_]) -> None:
    """Raise `InputError` unless there are enough samples and `t` increases strictly, by steps of a controlled arm.

    Parameters
    ----------
    t : (N,) array
        s.
    path : path
        The file, for the message.
    rows : (N,) array
        Number of each sample's row in the file.
    """
    if len(t) < FEWEST_ROWS:
        what = f"{path}: has too few samples"
        raise InputError(what, f"{len(t)} (at least {FEWEST_ROWS} are needed)", "give a longer recording")
    latest = float(np.abs(t).max())
    if latest > _LATEST:
        raise InputError(f"{path}: column t is beyond {_LATEST:g} s", f"{latest:g}", "give t in seconds")
    stopped = np.diff(t) <= 0.0
    if not stopped.any():
        _check_step(float(np.median(np.diff(t))), path)
        return
    i = int(stopped.argmax()) + 1
    before, now = float(t[i - 1]), float(t[i])
    fault = "repeats the time of the row before" if now == before else "goes back in time"
    more = int(stopped.sum())
    ordered = "sort the rows by t and drop repeated ones"
    do = ordered if now == before else f"split the recording there if its clock was set back, else {ordered}"
    do += f" ({more} rows are like that)" if more > 1 else ""
    raise InputError(f"{path}: column t, row {rows[i]} {fault}", f"{now!r} after {before!r}", do)


def _check_step(step: float, path: Path) -> None:
    if step > _LONGEST_STEP:
        what = f"{path}: column t has a median step above {_LONGEST_STEP:g} s, and no arm is controlled so slowly"
        raise InputError(what, f"{step:g}", "give t in seconds; milliseconds are a common slip")
    if step < _SHORTEST_STEP:
        what = f"{path}: column t has a median step under {_SHORTEST_STEP:g} s, and no arm is recorded so fast"
        raise InputError(what, f"{step:g}", "give t in seconds, not in minutes or hours")


def check_units(run: Run, path: Path, kinds: Sequence[str]) -> tuple[str, ...]:
    """Return warnings about doubtful units; raise `InputError` for values that no arm reaches.

    Parameters
    ----------
    run : Run
        With finite values and increasing time.
    path : path
        The file, for the message.
    kinds : sequence of str
        Of the joints, ``revolute`` or ``prismatic``.
    """
    for key, values, limit, revolute in (
        ("q", run.q, _LARGEST_POSITION, "rad"),
        ("tau", run.tau, _LARGEST_TORQUE, "N m"),
        ("dq", run.dq, _LARGEST_VELOCITY, "rad/s"),
    ):
        if values is None:
            continue
        peaks = np.abs(values).max(axis=0)
        k = int(peaks.argmax())
        if peaks[k] > limit:
            unit = unit_at(revolute, kinds[k])
            turns = ", whole turns left out" if unit == "rad" else ""
            raise InputError(
                f"{path}: column {key}{k + 1} is beyond {limit:g} {unit}", f"{peaks[k]:g}", f"give it in {unit}{turns}"
            )
    return (*_doubtful_positions(run, kinds), *_doubtful_velocities(run, kinds))


def _doubtful_positions(run: Run, kinds: Sequence[str]) -> list[str]:
    peaks = np.abs(run.q).max(axis=0)
    return [
        f"q{k + 1} reaches {peak:g} {unit_at('rad', kind)}: are these {_slip(kind)}?"
        for k, (peak, kind) in enumerate(zip(peaks, kinds, strict=True))
        if peak > _DOUBTFUL_POSITION
    ]


def _slip(kind: str) -> str:
    """Return the unit in which positions are often given instead."""
    return "mm" if kind == "prismatic" else "degrees"


def _doubtful_velocities(run: Run, kinds: Sequence[str]) -> list[str]:
    """Compare the change of q with the integral of dq: their slope is 1 unless the units (or signs) differ."""
    if run.dq is None:
        return []
    found = []
    step, moved = np.diff(run.t), np.diff(turned_on(run.q, run.t)[0], axis=0)
    for k in range(run.n):
        travelled = 0.5 * (run.dq[1:, k] + run.dq[:-1, k]) * step
        power = float(travelled @ travelled)
        if power == 0.0 or np.ptp(run.q[:, k]) < 0.05:
            continue
        slope = float(travelled @ moved[:, k]) / power
        if not 0.5 < slope < 2.0:
            hint = (
                f"one of them in {_slip(kinds[k])}?" if slope > 20.0 or 0.0 < slope < 0.05 else "check units and signs"
            )
            found.append(f"q{k + 1} changes {slope:.3g} times as fast as dq{k + 1} says: {hint}")
    return found
