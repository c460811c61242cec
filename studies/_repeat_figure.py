"""Estimates of each constant over many draws, by method."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from _repeats import Repeat
from matplotlib.figure import Figure

from stribeck.report.style import COLOUR, MUTED, drawn, grid, heading, new_figure, title

COLOURS = {"section3": COLOUR["as_given"], "ipopt": COLOUR["corrected"], "least_squares": COLOUR["partner"]}
LABELS = {"section3": "Section 3", "ipopt": "IPOPT", "least_squares": "least squares"}
NAMES = ("C0", "C1", "C2", "alpha")


@drawn
def repeat_figure(repeats: Mapping[str, list[Repeat]], truth: Callable[[str], np.ndarray]) -> Figure:
    """Draw, for each joint and constant, the estimate over the true value as boxes, one a method."""
    figure = new_figure(4.0)
    axes = figure.subplots(1, len(repeats), sharey=True)
    for ax, (joint, rows) in zip(axes, repeats.items(), strict=True):
        true = truth(joint)
        for m, method in enumerate(LABELS):
            values = np.array([row.constants[method] for row in rows]) / true
            columns = [column[np.isfinite(column)] for column in values.T]
            at = np.arange(4) + 0.26 * (m - 1)
            boxes = ax.boxplot(columns, positions=at, widths=0.2, showfliers=False, patch_artist=True, whis=(5, 95))
            for box in boxes["boxes"]:
                box.set(facecolor=COLOURS[method], alpha=0.75, linewidth=0.6)
            for line in boxes["medians"]:
                line.set(color="black", linewidth=0.9)
        ax.axhline(1.0, color=MUTED, linewidth=0.8)
        ax.set_xticks(range(4), NAMES)
        ax.set(ylim=(-2.0, 6.0))
        title(ax, f"Joint {joint}: estimate over true value", 4.4)
        grid(ax)
    for m, method in enumerate(LABELS):
        axes[0].text(0.02, 0.95 - 0.07 * m, LABELS[method], transform=axes[0].transAxes, color=COLOURS[method],
                     fontweight="bold", va="top")  # fmt: skip
    heading(
        figure, "Section 3 reads alpha off a difference that noise swamps; a fit does not (boxes: half, whiskers: 90 %)"
    )
    return figure
