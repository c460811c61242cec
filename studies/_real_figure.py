"""How surely an effect is seen in recordings of a real arm, over how much of the gap it makes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.figure import Figure

from stribeck.gap.answer.verdict import NAMED_OVER
from stribeck.report.style import COLOUR, MUTED, drawn, grid, heading, new_figure

MARKS = {"shoulder": "o", "elbow": "s"}
FOUND = {"named": COLOUR["corrected"], "not named": MUTED, "another named": "#d55e00"}


@drawn
def figure(rows: Sequence[Mapping[str, Any]]) -> Figure:
    """Draw each effect's probability of presence over what it adds to the gap that re-tuning leaves."""
    drawing = new_figure(4.6)
    ax = drawing.add_subplot()
    for row in rows:
        kind = "named" if row["right"] else "another named" if row["wrong"] else "not named"
        style: dict[str, Any] = {"color": FOUND[kind], "markersize": 7, "markeredgecolor": "white"}
        ax.plot(row["gap_grown"], row["presence"], MARKS[row["joint"]], **style)
        if row["gap_grown"] > 1.0 and not row["right"]:
            label = row["effect"].replace("_", " ")
            where = (row["gap_grown"], row["presence"])
            ax.annotate(label, where, (4, 5), textcoords="offset points", rotation=35, color=MUTED, fontsize=8)
    ax.axhline(NAMED_OVER, color=MUTED, linewidth=0.8, linestyle="--")
    ax.axvline(1.0, color=MUTED, linewidth=0.8, linestyle=":")
    for label, colour in FOUND.items():
        ax.plot([], [], "o", color=colour, label=label)
    for joint, mark in MARKS.items():
        ax.plot([], [], mark, color=MUTED, label=joint)
    ax.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False, fontsize=9)
    ax.set(ylim=(-0.03, 1.0), xlim=(-0.05, None))
    ax.set_xlabel("what the effect adds to the re-tuned residual, over that of the arm as recorded")
    ax.set_ylabel("stated probability that it is there")
    grid(ax)
    right = sum(row["right"] for row in rows)
    heading(drawing, f"{right} of {len(rows)} laws put into recordings of a real arm are named (dashed: from there on)")
    return drawing
