"""Rows that repeat the positions before them: a log that is written faster than an encoder is read."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stribeck.run.held import on_rows
from stribeck.run.values import Run

FEWEST = 50  # changes of position, that show how often it is read
REGULAR = 0.9  # of the rows from one to the next, that are as many, or twice as many, ...
COUNTS = 1.5  # of the smallest change, that the usual one must exceed: an encoder that counts slowly repeats itself too


def without_repeats(run: Run) -> tuple[Run, tuple[str, ...]]:
    """Return a run with the rows alone in which positions were read, and a note where any are left out.

    What was commanded in between is averaged over time, so that its impulse is kept. Where nothing moves, as many rows
    are left out as where it does.

    Parameters
    ----------
    run : Run
        With N samples.

    Returns
    -------
    run : Run
        With M samples; the same one where positions are new in every row, or now and then.
    notes : tuple of str
    """
    change = np.max(np.abs(np.diff(run.q, axis=0)), axis=1)
    changed = np.flatnonzero(change) + 1
    every, sizes = period_of(changed), change[changed - 1]
    if every < 2 or np.median(sizes) < COUNTS * sizes.min():
        return run, ()
    rows = read_rows(changed, every, len(run.t))
    note = f"{run.name}: positions are new in every {ordinal(every)} row only; those between are left out"
    return on_rows(run, rows), (note,)


def period_of(rows: NDArray[np.int_]) -> int:
    """Return how many rows lie from one of some rows (K,) to the next, by far most of the time; 1 if no number does."""
    apart = np.diff(rows)
    if len(apart) < FEWEST:
        return 1
    every = int(np.argmax(np.bincount(apart)))
    return every if np.mean(apart % every == 0) >= REGULAR else 1


def read_rows(changed: NDArray[np.int_], every: int, rows: int) -> NDArray[np.int_]:
    """Return the rows in which positions were read: those that changed, and so many apart where nothing moved.

    Parameters
    ----------
    changed : array (K,) of int
        Rows that show that they were read.
    every : int
        Rows from one reading to the next.
    rows : int
        Of the run.
    """
    last = np.full(rows, changed[0])
    last[changed] = changed
    last = np.maximum.accumulate(last)
    return np.flatnonzero((np.arange(rows) - last) % every == 0)


def ordinal(number: int) -> str:
    """Return a number as a place in a row."""
    return {2: "second", 3: "third"}.get(number, f"{number}th")
