"""The table of what re-tuning makes of the arm file's values."""

from __future__ import annotations

import math

from stribeck.gap.result import Diagnosis, Tuned
from stribeck.report import words
from stribeck.report.numbers import as_written, estimate, interval, unit_text
from stribeck.report.page import Row, Table

NOTE = (
    "Tolerance: one standard deviation, as the arm file states it. At its limit: the data push it to three or more, "
    "where masses end and friction does not. Uncertain: half the tolerance or more is left, one standard deviation and "
    "the pull of the runs' noise taken together; the value may still be off nominal for sure. Held: a tolerance of "
    "zero. Values of the file's effects have none: re-tuning finds them anew, and flags those far off."
)
BESIDE = (
    " Re-tuned: without the causes, whose part it takes over where it can. With the causes: as corrected.toml has it; "
    "intervals and remarks are of these."
)


def tuned_table(diagnosis: Diagnosis) -> Table:
    """Return the arm file's values before and after re-tuning, with what to mind about each.

    Intervals and remarks are those of the arm that is delivered.
    """
    beside = {value.key: value for value in diagnosis.corrected}
    rows = []
    for value in diagnosis.tuned:
        last = beside.get(value.key, value)
        held = value.tolerance == 0.0
        cells = (
            words.clean(value.key),
            as_written(value.nominal),
            as_written(value.tolerance) if math.isfinite(value.tolerance) else "none",
            *(["" if held else estimate(value.tuned)] if beside else []),
            *(("", "") if held else (estimate(last.tuned), interval(last.tuned))),
            unit_text(value.unit),
            "; ".join(_remarks(last)),
        )
        mark = "" if last.identified and not held else "muted"
        rows.append(Row(cells, "flag" if last.at_limit or last.moved else mark))
    tuned = ("re-tuned", "with the causes") if beside else ("re-tuned",)
    columns = ("value", "nominal", "± tolerance", *tuned, "95 % interval", "unit", "")
    numbers = frozenset(range(1, 4 + len(tuned)))
    return Table("Re-tuned values", columns, tuple(rows), numbers, NOTE + BESIDE * bool(beside))


def _remarks(value: Tuned) -> list[str]:
    held = value.tolerance == 0.0
    flags = ["at its limit"] * value.at_limit + ["uncertain"] * (not value.identified and not held)
    return flags + ["held"] * held + ["far from nominal"] * value.moved
