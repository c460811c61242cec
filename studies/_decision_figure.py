"""Right names against wrong ones: a point a rule and residual, lines for its other thresholds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from stribeck.report.style import COLOUR, MUTED, drawn, grid, heading, new_figure

MARKS = {"torque": "o", "motion": "s", "both": "D"}
LINES = {"torque": "-", "motion": "--"}
COLOURS = {
    "BIC": "#d55e00", "likelihood ratio": "#e69f00", "block score": "#009e73",
    "held-out gain": "#56b4e9", "stacking": "#cc79a7", "shipped": COLOUR["corrected"],
}  # fmt: skip


@drawn
def decision_figure(result: Mapping[str, Any]) -> Figure | None:
    """Draw the share of single effects named right over the share of all cases in which something wrong is named.

    None without single effects.
    """
    if result["methods"][0]["right"]["n"] == 0:
        return None
    figure = new_figure(4.8)
    ax = figure.add_subplot()
    for row in result["methods"]:
        right, wrong, colour = row["right"], row["wrong"], COLOURS[row["rule"]]
        x, y = 100 * wrong["value"], 100 * right["value"]
        ax.hlines(y, *(100 * end for end in wrong["ci95"]), color=colour, alpha=0.25, linewidth=1.0)
        ax.vlines(x, *(100 * end for end in right["ci95"]), color=colour, alpha=0.25, linewidth=1.0)
        if row["domain"] in LINES and "curve" in row:
            _, rights, wrongs = np.array(row["curve"]).T
            shares = 100 * wrongs / row["wrong"]["n"], 100 * rights / row["right"]["n"]
            ax.plot(*shares, LINES[row["domain"]], color=colour, linewidth=1.0)
        size = 11 if row["rule"] == "shipped" else 8
        ax.plot(x, y, MARKS[row["domain"]], color=colour, markersize=size, markeredgecolor="white")
    for rule, colour in COLOURS.items():
        ax.plot([], [], "o", color=colour, label=rule)
    for domain, mark in MARKS.items():
        ax.plot([], [], mark, color=MUTED, label=f"on {domain}")
    for domain, line in LINES.items():
        ax.plot([], [], line, color=MUTED, linewidth=1.0, label=f"other thresholds, {domain}")
    ax.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False, fontsize=9)
    ax.set(xlim=(-3.0, None), ylim=(-3.0, 103.0))
    ax.text(0.0, 101.0, "better", color=MUTED, fontsize=9, ha="left", va="bottom")
    ax.set_xlabel("cases in which something wrong is named, %")
    ax.set_ylabel("single effects named right and alone, %")
    grid(ax)
    best = [f"{rule} on {domain}" for rule, domain in result["best"]]
    found = f"best is {best[0]}" if len(best) == 1 else f"{len(best)} are equally good"
    heading(figure, f"{result['cases']} sealed cases, same fits: at usual thresholds {found} (bars: 95 %)")
    return figure
