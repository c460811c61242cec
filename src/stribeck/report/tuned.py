"""The table of what re-tuning makes of the arm file's values."""

from __future__ import annotations

import math

from stribeck.gap.result import Diagnosis
from stribeck.report import words
from stribeck.report.numbers import as_written, estimate, interval, unit_text
from stribeck.report.page import Row, Table


def tuned_table(diagnosis: Diagnosis) -> Table:
    """Return the arm file's values before and after re-tuning, with what to mind about each."""
    rows = []
    for value in diagnosis.tuned:
        held = value.tolerance == 0.0
        flags = ["at its limit"] * value.at_limit + ["not identified"] * (not value.identified and not held)
        flags += ["held"] * held + ["far from nominal"] * value.moved
        cells = (
            words.clean(value.key),
            as_written(value.nominal),
            as_written(value.tolerance) if math.isfinite(value.tolerance) else "none",
            *(("", "") if held else (estimate(value.tuned), interval(value.tuned))),
            unit_text(value.unit),
            "; ".join(flags),
        )
        mark = "" if value.identified and not held else "muted"
        rows.append(Row(cells, "flag" if value.at_limit or value.moved else mark))
    columns = ("value", "nominal", "± tolerance", "re-tuned", "95 % interval", "unit", "")
    note = (
        "Tolerance: one standard deviation, as the arm file states it; re-tuning stays within three. At its limit: the "
        "data want more than that. Not identified: these runs cannot tell; it stays near nominal. Held: a "
        "tolerance of zero. Values of the file's effects have none: re-tuning finds them anew, and flags those far off."
    )
    return Table("Re-tuned values", columns, tuple(rows), frozenset({1, 2, 3, 4}), note)
