"""What positions that are early by nearly half a row may come from: a log of some commands of a faster controller.

A row's command counts as held up to the next. Where the log has it as it was in its row, while a controller gave some
more up to the next, it is late by half of what lies between: (h - T) / 2 of rows h and commands T apart.
"""

from __future__ import annotations

from collections.abc import Sequence

from stribeck.gap.result import Cause

EARLY = "time_shift"
PARTS = (0.25, 0.5)  # of a row, by which positions are early: of two commands a row, and of many


def told_as_sampled(causes: Sequence[Cause], named: Sequence[str], step: float) -> list[str]:
    """Return a note where a named shift may be the log's way to write commands, and what to record if it is.

    Parameters
    ----------
    causes : sequence of Cause
        With their parameters.
    named : sequence of str
        Effects that the diagnosis names.
    step : float
        From row to row, s.
    """
    told = []
    for cause in causes:
        times = [values["time"] for values in cause.parameters.values()] if cause.effect == EARLY else []
        if EARLY in named and times and all(t.low <= -PARTS[0] * step and t.high >= -PARTS[1] * step for t in times):
            told.append(
                f"{EARLY}: by {1e3 * times[0].value:.2g} ms, up to half of the {1e3 * step:.3g} ms from row to row: so "
                "it is where a controller is faster than the log, which has but the commands of its own rows; if yours "
                "is, record every command"
            )
    return told
