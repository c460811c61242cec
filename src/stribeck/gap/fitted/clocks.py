"""The clocks of the runs, set so that a disturbance from outside has one phase in all of them.

What shakes an arm does not know when a recording began. A wave in time has a phase of its own in each run, then; each
run is told it by its clock, which nothing but such a law reads.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.signal import zoom_fft

from stribeck.gap.fitted.model import Model, start_values
from stribeck.gap.records.prepare import Prepared
from stribeck.identify.conditioning import Conditioned
from stribeck.identify.residual import Residual
from stribeck.model.path import SignalPath

Floats = NDArray[np.float64]

RANGE = (0.3, 25.0)  # Hz
FINENESS = 0.125  # of one over the longest run: the step between frequencies
SHARE = 0.1  # of a joint's squared residual, that one wave must take
FAINT = 0.1  # of the loudest run's wave: one that is fainter has no phase to go by
PERIODIC = 0.6  # of a joint's squared velocity in one line: it moves to and fro at that frequency
ASTRAY = 0.03  # of a period, by which a clock must be off to be set anew
IN_STEP = 0.9  # of that, which one phase for all runs takes too: then their clocks are right as they are


def in_step(prepared: Prepared, rows: Floats) -> Prepared:
    """Return the runs with their clocks set by the strongest wave in time that a model leaves, if any.

    Parameters
    ----------
    prepared : Prepared
    rows : array (M, n)
        What the re-tuned model leaves of all runs, N m, without the waves in time that it has.

    Notes
    -----
    A run that is held out is set by its own residual: its phase is no more foretold than that of any new run. Where
    the motion itself repeats at that frequency in all runs, or at a part of it, what waves may be any law, and the
    clocks stay.
    """
    runs = (*prepared.fit, *prepared.held)
    edges = np.cumsum([len(run.analysis_index) for run in runs])[:-1]
    parts = np.split(rows, edges)
    steps = [run.decimation * run.sample_time for run in runs]
    fastest = min(RANGE[1], *(0.45 / step for step in steps))
    if min(len(part) for part in parts) < 8 or fastest <= RANGE[0]:
        return prepared
    longest = max(len(part) * step for part, step in zip(parts, steps, strict=True))
    grid = np.linspace(RANGE[0], fastest, int((fastest - RANGE[0]) * longest / FINENESS) + 2)
    found = [_wave(runs, [part[:, j] for part in parts], grid) for j in range(rows.shape[1])]
    share, waves = max(found, key=lambda wave: float(wave[0].max()))
    best = int(np.argmax(share))
    frequency = float(grid[best])
    sizes = np.abs(waves[:, best])
    loudest = int(np.argmax(sizes))
    if not share[best] >= SHARE or abs(waves[:, best].sum()) ** 2 > IN_STEP * sizes.sum() ** 2:
        return prepared
    if _repeats(runs, grid, frequency):
        return prepared
    late = np.angle(waves[:, best] * np.conj(waves[loudest, best])) / (2.0 * np.pi * frequency)
    late[sizes < FAINT * sizes[loudest]] = 0.0
    starts = np.array([run.told_time[0] for run in runs])
    clocks = late - late[0] + starts % (1.0 / frequency)
    moved = [replace(run, clock=float(clock)) for run, clock in zip(runs, clocks, strict=True)]
    return replace(prepared, fit=tuple(moved[: len(prepared.fit)]), held=tuple(moved[len(prepared.fit) :]))


def in_step_beside(prepared: Prepared, model: Model) -> Prepared:
    """Return the runs with their clocks set anew, where a model has a wave in time, and other laws that hid its phase.

    By what it leaves without that wave; the same ``prepared`` where no clock was far off.
    """
    waves = [place for place in model.placed if place.effect.patternless]
    if not waves or len(waves) == len(model.placed):
        return prepared
    before = (*prepared.fit, *prepared.held)
    anew = in_step(prepared, without_waves(prepared, model))
    moved = [run.told_time[0] - old.told_time[0] for run, old in zip((*anew.fit, *anew.held), before, strict=True)]
    turned = np.array([[place.values["frequency"] for place in waves]]).T * np.array(moved)
    return anew if np.any(np.abs(turned - np.round(turned)) > ASTRAY) else prepared


def without_waves(prepared: Prepared, model: Model) -> Floats:
    """Return what a model leaves of all runs (M, n), N m, without the waves in time that it has."""
    rest = [place for place in model.placed if not place.effect.patternless]
    if len(rest) == len(model.placed):
        return model.whole
    path = SignalPath(prepared.arm, rest)
    left, _ = Residual(path, (*prepared.fit, *prepared.held), ())(start_values(path, model.fit, None))
    return np.asarray(left)


def _repeats(runs: Sequence[Conditioned], grid: Floats, frequency: float) -> bool:
    """Return whether some joint's velocity has a line, in all runs together, at a frequency or at a part of it."""
    for j in range(runs[0].velocity.shape[1]):
        share, _ = _wave(runs, [run.velocity[run.analysis_index, j] for run in runs], grid)
        for part in (1, 2, 3):
            near = np.abs(grid - frequency / part) <= (grid[1] - grid[0]) / FINENESS
            if near.any() and share[near].max() > PERIODIC:
                return True
    return False


def _wave(runs: Sequence[Conditioned], parts: Sequence[Floats], grid: Floats) -> tuple[Floats, NDArray[np.complex128]]:
    """Return the share of all squares (F,) that a wave of each frequency takes, and its sums (R, F).

    The phases are those at 0 s by the clock that each run is told: where it began is nothing to a wave from outside.
    """
    sums = []
    for run, part in zip(runs, parts, strict=True):
        step = run.decimation * run.sample_time
        turned = zoom_fft(part - part.mean(), [grid[0], grid[-1]], len(grid), fs=1.0 / step, endpoint=True)
        sums.append(turned * np.exp(-2j * np.pi * grid * run.told_time[run.analysis_index[0]]))
    waves = np.array(sums)
    rows = np.array([len(part) for part in parts], dtype=float)
    whole = sum(float(np.sum((part - part.mean()) ** 2)) for part in parts)
    share = np.sum(2.0 * np.abs(waves) ** 2 / rows[:, None], axis=0) / max(whole, 1e-300)
    return share, waves
