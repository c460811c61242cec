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

from stribeck.gap.model import Model
from stribeck.gap.prepare import Prepared
from stribeck.identify.conditioning import Conditioned

Floats = NDArray[np.float64]

RANGE = (0.3, 25.0)  # Hz
FINENESS = 0.125  # of one over the longest run: the step between frequencies
SHARE = 0.1  # of a joint's squared residual, that one wave must take
IN_STEP = 0.9  # of that, which one phase for all runs takes too: then their clocks are right as they are


def in_step(prepared: Prepared, base: Model) -> Prepared:
    """Return the runs with their clocks set by the strongest wave in time that the re-tuned model leaves, if any.

    A run that is held out is set by its own residual: its phase is no more foretold than that of any new run.
    """
    runs = (*prepared.fit, *prepared.held)
    rows = np.concatenate([base.fit.residual, base.held])
    edges = np.cumsum([len(run.analysis_index) for run in runs])[:-1]
    parts = np.split(rows, edges)
    if min(len(part) for part in parts) < 8:
        return prepared
    found = [_wave(runs, [part[:, j] for part in parts]) for j in range(rows.shape[1])]
    share, frequency, waves = max(found, key=lambda wave: wave[0])
    if share < SHARE or abs(waves.sum()) ** 2 > IN_STEP * np.abs(waves).sum() ** 2:
        return prepared
    late = np.angle(waves / waves[0]) / (2.0 * np.pi * frequency)
    moved = [replace(run, time=run.time + shift) for run, shift in zip(runs, late, strict=True)]
    return replace(prepared, fit=tuple(moved[: len(prepared.fit)]), held=tuple(moved[len(prepared.fit) :]))


def _wave(runs: Sequence[Conditioned], parts: Sequence[Floats]) -> tuple[float, float, NDArray[np.complex128]]:
    """Return share of all squares, frequency (Hz) and complex amplitudes (R,) of the strongest wave in time."""
    steps = [run.decimation * run.sample_time for run in runs]
    fastest = min(RANGE[1], *(0.45 / step for step in steps))
    longest = max(len(part) * step for part, step in zip(parts, steps, strict=True))
    count = int((fastest - RANGE[0]) * longest / FINENESS) + 2
    grid = np.linspace(RANGE[0], fastest, count)
    sums = np.array(
        [
            zoom_fft(part - part.mean(), [RANGE[0], fastest], count, fs=1.0 / step, endpoint=True)
            * np.exp(-2j * np.pi * grid * run.time[run.analysis_index[0]])
            for run, part, step in zip(runs, parts, steps, strict=True)
        ]
    )
    rows = np.array([len(part) for part in parts], dtype=float)
    taken = np.sum(2.0 * np.abs(sums) ** 2 / rows[:, None], axis=0)
    best = int(np.argmax(taken))
    whole = sum(float(np.sum(part**2)) for part in parts)
    return float(taken[best]) / max(whole, 1e-300), float(grid[best]), sums[:, best]
