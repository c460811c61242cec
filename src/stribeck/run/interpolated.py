"""Rows on straight lines between others: a log that was put on a faster clock after it had been recorded."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stribeck.quantum import rounding
from stribeck.run.held import on_rows
from stribeck.run.repeats import REGULAR, ordinal, period_of, read_rows
from stribeck.run.values import Floats, Run

ROUNDINGS = 4.0  # of a value, by which rounding three of them may bend a line


def without_interpolated(run: Run) -> tuple[Run, tuple[str, ...]]:
    """Return a run with the rows alone between which positions lie on straight lines, and a note where there are any.

    Those between hold less of the encoder's noise than it has, and a blow to the joint at either end. A command that
    was interpolated as well is what it was in the rows that stay; any other is averaged from each to the next.

    Parameters
    ----------
    run : Run
        With N samples.

    Returns
    -------
    run : Run
        With M samples; the same one where positions bend in every row, or now and then.
    notes : tuple of str
    """
    bent = np.flatnonzero(np.any(_bends(run.q), axis=1)) + 1
    every = period_of(bent)
    if every < 2:
        return run, ()
    rows = read_rows(bent, every, len(run.t))
    between = np.delete(_bends(run.tau), rows[(rows > 0) & (rows < len(run.t) - 1)] - 1, axis=0)
    thinned = on_rows(run, rows)
    if np.mean(np.any(between, axis=1)) <= 1.0 - REGULAR:
        thinned = replace(thinned, tau=run.tau[rows], droop=None)
    note = f"{run.name}: positions lie on straight lines between every {ordinal(every)} row; those between are left out"
    return thinned, (note,)


def _bends(values: Floats) -> NDArray[np.bool_]:
    """Return where values (N, n) are off the line through those beside, (N - 2, n): all rows but the first and last."""
    least = ROUNDINGS * np.array([rounding(column) for column in values.T])
    return np.asarray(np.abs(np.diff(values, 2, axis=0)) > least)
