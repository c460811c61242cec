"""A run with positions as an encoder gives them that counts on and is read in every row."""

from __future__ import annotations

from dataclasses import replace

from stribeck.run.repeats import without_repeats
from stribeck.run.turns import turned_on
from stribeck.run.values import Run


def as_read(run: Run) -> tuple[Run, tuple[str, ...]]:
    """Return a run without leaps by whole turns and without repeated rows, and notes on what was done.

    Parameters
    ----------
    run : Run

    Returns
    -------
    run : Run
        The same one where nothing had to be done.
    notes : tuple of str
    """
    q, leaps = turned_on(run.q)
    if not leaps.any():
        return without_repeats(run)
    reference = None if run.q_ref is None else turned_on(run.q_ref)[0]
    fresh, notes = without_repeats(replace(run, q=q, q_ref=reference))
    told = ", ".join(f"q{k + 1} ({count} times)" for k, count in enumerate(leaps) if count)
    return fresh, (
        f"{run.name}: leaps by a turn, as of a counter that begins anew: {told}",
        *notes,
    )
