"""The figure of a power analysis: every case by its strength, named or missed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stribeck.report import words
from stribeck.report.style import COLOUR, INK, MUTED, RULE, drawn, grid, heading, key, new_figure

LEAST = 0.03  # strength; weaker ones are drawn at the edge
RANK = {"weak": 0, "medium": 1, "clear": 2}
KINDS = (
    ("named", COLOUR["corrected"], "o"),
    ("named, and another", COLOUR["partner"], "D"),
    ("missed", COLOUR["noise_floor"], "o"),
    ("wrong name", COLOUR["as_given"], "X"),
)


@drawn
def power_figure(score: Mapping[str, Any]) -> Figure | None:
    """Draw a line for each effect, those that are revealed best first; None without cases.

    ``score`` is the content of ``score.json`` with that of ``power.json`` under ``power``.
    """
    effects = score["power"]["effects"]
    if not effects:
        return None
    names = sorted(effects, key=lambda name: (RANK.get(effects[name]["revealed_from"] or "", 3), name))
    figure = new_figure(1.4 + 0.26 * len(names))
    draw_power(figure.subplots(), names, score["rows"])
    seen = sum(row["revealed_from"] is not None for row in effects.values())
    heading(figure, f"This experiment reveals {seen} of {len(names)} effects where they are {clearest(score['power'])}")
    return figure


def clearest(power: Mapping[str, Any]) -> str:
    """Return the clearest level at which effects were recorded."""
    levels = {level for row in power["effects"].values() for level in row["levels"]}
    return max(levels, key=lambda level: RANK[level], default="clear")


def draw_power(ax: Axes, names: Sequence[str], rows: Sequence[Mapping[str, Any]]) -> Axes:
    """Draw each case of one effect at its strength, marked by what was said; return ``ax``."""
    for row in rows:
        if len(row["effects"]) != 1 or row["effects"][0] not in names:
            continue
        _, colour, marker = KINDS[_kind(row)]
        face = "white" if _kind(row) == 2 else colour
        ax.plot(
            max(row["strength"], LEAST), names.index(row["effects"][0]), marker, color=colour, markerfacecolor=face,
            markersize=6.5, markeredgewidth=1.3,
        )  # fmt: skip
    for strength, style in ((1.0, ":"), (3.0, "--")):
        ax.axvline(strength, color=MUTED, linewidth=0.8, linestyle=style, zorder=0)
    ax.set_xscale("log")
    shown = [max(row["strength"], LEAST) for row in rows if row["strength"] is not None]
    ax.set_xlim(left=min([0.7, *(0.8 * strength for strength in shown)]))
    ax.xaxis.set_major_formatter(lambda x, _: f"{x:g}")
    ax.minorticks_off()
    ax.set_yticks(range(len(names)), [words.effect(name) for name in names])
    ax.set_ylim(len(names) - 0.4, -0.6)
    ax.tick_params(axis="y", length=0, labelcolor=INK)
    ax.set_xlabel("strength of the hidden effect: its torque / noise floor (lines at 1 and 3)")
    ax.grid(True, axis="y", color=RULE, linewidth=0.4)
    grid(ax, "x")
    key(ax, [(text, colour) for text, colour, _ in KINDS])
    return ax


def _kind(row: Mapping[str, Any]) -> int:
    if row["found"]:
        return 1 if row["extra"] else 0
    return 3 if row["extra"] else 2
