"""Which open cases each kind of next recording settles."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from stribeck.report.style import COLOUR, MUTED, drawn, heading, new_figure, title

LABELS = {"proposed": "proposed", "random": "random", "d_optimal": "D-optimal"}


@drawn
def next_figure(result: Mapping[str, Any]) -> Figure | None:
    """Draw a row a case and a column a method, filled where the hidden effect is named, and the shares resolved."""
    rows = [row for row in result["rows"] if row["open"] and not row["exact"]]
    figure = new_figure(1.8 + 0.26 * max(len(rows), 4), 9.0)
    table, shares = figure.subplots(1, 2, width_ratios=(1.6, 1.0))
    for k, method in enumerate(LABELS):
        marks = np.array([_mark(row, method) for row in rows])
        for value, colour, label in ((1, COLOUR["corrected"], "resolved"), (0, COLOUR["noise_floor"], "left open"),
                                     (-1, COLOUR["as_given"], "something else named")):  # fmt: skip
            at = np.flatnonzero(marks == value)
            table.scatter(np.full(len(at), k), at, s=70, color=colour, label=label if k == 0 else None)
    table.set_yticks(range(len(rows)), [f"{row['effect']} (strength {row['strength']:.2g})" for row in rows])
    table.set_xticks(range(len(LABELS)), list(LABELS.values()))
    table.set(xlim=(-0.5, len(LABELS) - 0.5), ylim=(len(rows) - 0.5, -0.5))
    title(table, "After one more recording", 4.4)
    values = [result["resolved"][method] for method in LABELS]
    for k, one in enumerate(values):
        low, high = one["ci95"]
        shares.bar(k, 100.0 * one["value"], 0.6, color=COLOUR["corrected"] if k == 0 else COLOUR["noise_floor"])
        shares.plot([k, k], [100.0 * low, 100.0 * high], color=MUTED, linewidth=1.2)
    shares.set_xticks(range(len(LABELS)), list(LABELS.values()))
    shares.set(ylim=(0.0, 100.0), ylabel="% of open cases (lines: 95 %)")
    title(shares, "Resolved in one go", 3.0)
    figure.legend(loc="outside lower left", frameon=False, ncols=3, fontsize=9)
    heading(figure, f"{len(rows)} open cases, recorded once more: as proposed, at random, D-optimal", 9.0)
    return figure


def _mark(row: Mapping[str, Any], method: str) -> int:
    if row["experiment"] is None:
        return 0
    after = row["after"][method]
    return 1 if after["right"] else -1 if after.get("wrong") else 0
