"""The confusion matrix of a withheld check: what was said by what was hidden."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stribeck.blind.outcome import CHANNELS
from stribeck.report import words
from stribeck.report.figures.withheld import WRONG, cases
from stribeck.report.style import INK, MUTED, RULE, WIDTH, drawn, heading, new_figure

Score = Mapping[str, Any]


@drawn
def confusion_figure(score: Score) -> Figure | None:
    """Draw what was said by what was hidden, as shares of each row; None without cases."""
    table = score["confusion"]
    counts = np.array(table["counts"], dtype=float)
    if counts.size == 0:
        return None
    width = min(WIDTH, 4.0 + 0.3 * len(table["said"]))
    figure = new_figure(1.9 + 0.24 * len(table["hidden"]), width)
    table, counts = _by_stage(table, counts)
    draw_confusion(figure.subplots(), table, counts)
    wrong = sum(counts[i, j] for i, j in zip(*np.nonzero(counts), strict=True) if _is_wrong(table, i, j))
    heading(figure, f"A wrong name in place of what was hidden: {wrong:.0f} of {cases(int(counts.sum()))}", width)
    return figure


def _by_stage(table: Score, counts: np.ndarray) -> tuple[Score, np.ndarray]:
    """Sort rows and columns by stage of the signal path, then by name."""
    down, across = (sorted(range(len(table[key])), key=lambda i: _place(table[key][i])) for key in ("hidden", "said"))
    ordered = {"hidden": [table["hidden"][i] for i in down], "said": [table["said"][j] for j in across]}
    return ordered, counts[np.ix_(down, across)]


def _place(name: str) -> tuple[int, str]:
    """Return where a name stands: by its stage, what no library holds after all stages, what is no name last."""
    stages = tuple(dict.fromkeys(CHANNELS.values()))
    last = ("left_out", "none", "unknown", "failed")
    if name in last:
        return len(stages) + 1 + last.index(name), name
    return (stages.index(CHANNELS[name]) if name in CHANNELS else len(stages)), words.effect(name)


def _is_wrong(table: Score, i: int, j: int) -> bool:
    return table["said"][j] not in (table["hidden"][i], "none", "unknown", "failed")


def draw_confusion(ax: Axes, table: Score, counts: np.ndarray) -> Axes:
    """Draw a matrix of counts, shaded by the share of each row; return ``ax``."""
    shares = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1.0)
    ax.imshow(shares, cmap="Blues", vmin=0.0, vmax=1.3, aspect="auto")
    for i, j in zip(*np.nonzero(counts), strict=True):
        same = table["said"][j] == table["hidden"][i]
        wrong = _is_wrong(table, i, j)
        colour = WRONG if wrong else "white" if shares[i, j] > 0.75 else INK
        weight = "bold" if wrong or same else "normal"
        ax.text(j, i, f"{counts[i, j]:.0f}", ha="center", va="center", fontsize=8, color=colour, fontweight=weight)
    ax.set_xticks(range(len(table["said"])), [_label(n) for n in table["said"]], rotation=60, ha="right", fontsize=8)
    ax.set_yticks(range(len(table["hidden"])), [_label(name, hidden=True) for name in table["hidden"]], fontsize=8)
    ax.set_xticks(np.arange(len(table["said"]) + 1) - 0.5, minor=True)
    ax.set_yticks(np.arange(len(table["hidden"]) + 1) - 0.5, minor=True)
    ax.grid(which="minor", color=RULE, linewidth=0.4)
    for names, line in ((table["said"], ax.axvline), (table["hidden"], ax.axhline)):
        for k in range(1, len(names)):
            if _place(names[k - 1])[0] != _place(names[k])[0]:
                line(k - 0.5, color=MUTED, linewidth=0.9)
    ax.tick_params(which="both", length=0, labelcolor=INK)
    ax.spines[:].set_visible(False)
    ax.set_xlabel("said (in its class: counts as its name; orange: a wrong name)")
    ax.set_ylabel("hidden")
    return ax


def _label(name: str, hidden: bool = False) -> str:
    silent = {
        "none": "nothing" if hidden else "no gap",
        "unknown": "no name",
        "failed": "failed",
        "left_out": "one left out of the library",
    }
    if name in silent:
        return silent[name]
    return words.effect(name)
