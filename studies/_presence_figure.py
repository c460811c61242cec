"""How often effects were there against how surely that was said, for two sets of weights."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from matplotlib.figure import Figure

from stribeck.blind.rates import rate
from stribeck.report.style import COLOUR, MUTED, drawn, grid, heading, new_figure

EDGES = (0.0, 0.2, 0.4, 0.6, 0.8, 0.9, 1.0)


@drawn
def presence_figure(shipped: np.ndarray, crossed: np.ndarray, right: np.ndarray) -> Figure:
    """Draw the share (95 % interval) of taken effects that were there over the mean stated probability, bin by bin."""
    figure = new_figure(4.6)
    ax = figure.add_subplot()
    ax.plot([0, 100], [0, 100], "--", color=MUTED, linewidth=0.8)
    for chance, colour, label, aside in (
        (shipped, COLOUR["corrected"], "shipped weights", -0.6),
        (crossed, COLOUR["retuned"], "weights of the other folds", 0.6),
    ):
        ax.plot([], [], "o", color=colour, label=label)
        for low, high in pairwise(EDGES):
            here = (chance > low) & (chance <= high)
            if not here.any():
                continue
            found = rate(right[here] > 0.5)
            x = 100 * float(chance[here].mean()) + aside
            ax.vlines(x, *(100 * end for end in found["ci95"]), color=colour, linewidth=1.6)
            ax.plot(x, 100 * found["value"], "o", color=colour)
            side = {"ha": "right" if aside < 0 else "left", "va": "center", "fontsize": 8, "color": colour}
            ax.annotate(str(found["n"]), (x, 100 * found["value"]), (12 * aside, 0), textcoords="offset points", **side)
    ax.set(xlim=(0, 100), ylim=(0, 103))
    ax.set_xlabel("stated probability that a taken effect is there, %")
    ax.set_ylabel("share that was there, %")
    ax.legend(loc="upper left", frameon=False)
    grid(ax)
    heading(figure, f"{len(right)} effects that the search took: stated against true (bars: 95 %; numbers: effects)")
    return figure
