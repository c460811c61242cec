"""A run with positions as an encoder gives them that counts on and is read in every row."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stribeck.run.interpolated import without_interpolated
from stribeck.run.repeats import without_repeats
from stribeck.run.spikes import without_spikes
from stribeck.run.turns import turned_on
from stribeck.run.values import Run


def as_read(run: Run) -> tuple[Run, tuple[str, ...]]:
    """Return a run without leaps by whole turns, wrong readings and rows that are no readings, and notes on that.

    Parameters
    ----------
    run : Run

    Returns
    -------
    run : Run
        The same one where nothing had to be done.
    notes : tuple of str
    """
    notes: list[str] = []
    q, leaps = turned_on(run.q, run.t)
    if leaps.any():
        run = replace(run, q=q, q_ref=None if run.q_ref is None else turned_on(run.q_ref, run.t)[0])
        notes.append(f"{run.name}: leaps by a turn, as of a counter that begins anew: {_listed(leaps)}")
    run, said = without_repeats(run)
    run, lines = without_interpolated(run)
    q, wrong = without_spikes(run.t, run.q)
    if wrong.any():
        run = replace(run, q=q)
        notes.append(f"{run.name}: positions that leap and are back, taken from rows around: {_listed(wrong)}")
    return run, (*notes, *said, *lines)


def _listed(times: NDArray[np.int_]) -> str:
    return ", ".join(f"q{k + 1} ({count} times)" for k, count in enumerate(times) if count)
