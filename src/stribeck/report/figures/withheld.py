"""The figures of a withheld check: what was named at which strength, and whether the probabilities held."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stribeck.report import words
from stribeck.report.numbers import number, percent
from stribeck.report.style import COLOUR, INK, MUTED, RULE, drawn, grid, heading, new_figure

BINS = {"strong": "3 and more", "fair": "1 to 3", "faint": "below 1"}
ASKED = {"strong": 0.90, "fair": 0.75}
RIGHT, WRONG, SILENT = COLOUR["corrected"], COLOUR["as_given"], COLOUR["noise_floor"]
TICKS = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0)
ALL = 0.985  # of a gap: as good as closed, where marks lie on top of each other
FARTHEST = (0.01, 1000.0)  # a bootstrap over a few cases gives intervals without end
Score = Mapping[str, Any]


@drawn
def strength_figure(score: Score) -> Figure | None:
    """Draw what was said of single effects by strength: named right, named wrong, nothing; None without such cases."""
    bins = [name for name in BINS if score["single"][name]["named"]["n"]]
    if not bins:
        return None
    figure = new_figure(1.5 + 0.85 * len(bins))
    draw_strengths(figure.subplots(), score["single"], bins)
    every = score["single"]["all"]
    named, wrong = percent(every["named"]["value"]), percent(every["wrong_name"]["value"])
    heading(
        figure, f"{named} of {every['named']['n']} hidden effects are named, {wrong} of the answers give a wrong name"
    )
    return figure


@drawn
def strength_left_figure(score: Score) -> Figure | None:
    """Draw the same by what re-tuning leaves of the strength; None where the key does not record it."""
    found = score.get("single_left")
    bins = [name for name in BINS if found and found[name]["named"]["n"]]
    if not found or not bins:
        return None
    figure = new_figure(1.5 + 0.85 * len(bins))
    draw_strengths(figure.subplots(), found, bins, "torque left after re-tuning / noise floor")
    strong = found[bins[0]]["named"]
    heading(figure, f"Where re-tuning leaves {BINS[bins[0]]}, {strong['k']} of {cases(strong['n'])} are named")
    return figure


def draw_strengths(ax: Axes, single: Score, bins: Sequence[str], label: str = "effect torque / noise floor") -> Axes:
    """Draw shares with their intervals, a row for each bin and measure, asked shares as ticks; return ``ax``."""
    measures = (
        ("named", RIGHT, "named right"),
        ("wrong_name", WRONG, "a wrong name"),
        ("abstained", SILENT, "no name"),
    )
    for place, name in enumerate(bins):
        for k, (key, colour, text) in enumerate(measures):
            y = place + 0.24 * (k - 1)
            _share(ax, single[name][key], y, colour)
            ax.annotate(
                f"{text}, {percent(single[name][key]['value'])}", (1.0, y), xytext=(8, 0), textcoords="offset points",
                va="center", fontsize=9, color=colour if key != "abstained" else MUTED, annotation_clip=False,
            )  # fmt: skip
        if name in ASKED:
            ax.plot([ASKED[name]] * 2, [place - 0.36, place - 0.12], color=INK, linewidth=1.4)
    ax.set_yticks(range(len(bins)), [f"{BINS[name]}\n{cases(single[name]['named']['n'])}" for name in bins])
    ax.set_ylim(len(bins) - 0.5, -0.5)
    ax.set_title(f"by {label}", color=MUTED, fontsize=10.0, fontweight="normal")  # a row is lower than that is long
    _shares(ax, "x", "share of cases (95 % interval; the tick is what is asked)")
    return ax


@drawn
def reliability_figure(score: Score) -> Figure | None:
    """Draw how often stated probabilities held; None without statements."""
    found = score["calibration"]["likeliest"]
    if not found["bins"]:
        return None
    figure = new_figure(4.6)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(4, 1))
    draw_reliability(upper, found["bins"])
    bars = lower.bar(
        [b["stated"] for b in found["bins"]], [b["held"]["n"] for b in found["bins"]], width=0.04, color=SILENT
    )  # fmt: skip
    lower.bar_label(bars, padding=2, fontsize=9, color=MUTED)
    lower.set_ylim(0.0, 1.35 * max(b["held"]["n"] for b in found["bins"]))
    lower.set_yticks([])
    lower.set_ylabel("answers")
    _shares(lower, "x", "stated probability of the likeliest answer")
    error, chance = number(found["ece"], 2), number(found["ece_by_chance"], 2)
    heading(figure, f"Stated probabilities are off by {error} on average; {chance} by chance alone")
    return figure


def draw_reliability(ax: Axes, bins: Sequence[Score]) -> Axes:
    """Draw the rate that held over the mean stated probability, with intervals; return ``ax``."""
    ax.plot([0, 1], [0, 1], color=MUTED, linewidth=0.8, linestyle="--")
    for b in bins:
        low, high = b["held"]["ci95"]
        ax.plot([b["stated"]] * 2, [low, high], color=RIGHT, linewidth=1.8)
        ax.plot(b["stated"], b["held"]["value"], "o", color=RIGHT, markersize=6)
    _shares(ax, "y", "share that was so")
    return ax


@drawn
def limits_figure(score: Score) -> Figure | None:
    """Draw each effect's detection limit, the easiest first; None where none was found."""
    rows = [(name, row["detection_limit"], row["named"]) for name, row in score["effects"].items()]
    rows = [row for row in rows if row[1] is not None]
    if not rows:
        return None
    rows.sort(key=lambda row: (row[1]["outside"] == "above", row[1]["strength"]))
    figure = new_figure(1.2 + 0.26 * len(rows))
    draw_limits(figure.subplots(), rows)
    easy = sum(row[1]["outside"] != "above" and row[1]["strength"] <= 3.0 for row in rows)
    heading(figure, f"{easy} of {len(rows)} effects are named half of the time at 3 noise floors or less")
    return figure


def draw_limits(ax: Axes, rows: Sequence[tuple[str, Score, Score]]) -> Axes:
    """Draw limits with intervals on a logarithmic axis, arrows where they lie beyond what was tried; return ``ax``."""
    for place, (_, limit, named) in enumerate(rows):
        low, high = limit["ci95"]
        marker = {"below": "<", "above": ">"}.get(limit["outside"], "o")
        colour = SILENT if limit["outside"] == "above" else RIGHT
        ax.plot([low, high], [place, place], color=colour, linewidth=1.8, solid_capstyle="butt")
        ax.plot(limit["strength"], place, marker, color=colour, markersize=6.5)
        ax.annotate(
            f"{named['k']} of {named['n']}", (1.0, place), xycoords=("axes fraction", "data"), xytext=(8, 0),
            textcoords="offset points", va="center", fontsize=9, color=MUTED, annotation_clip=False,
        )  # fmt: skip
    ax.set_xscale("log")
    low, high = np.clip(ax.get_xlim(), *FARTHEST)
    ax.set_xlim(low, high)
    ax.set_xticks([tick for tick in TICKS if low <= tick <= high], minor=False)
    ax.xaxis.set_major_formatter(lambda x, _: f"{x:g}")
    ax.minorticks_off()
    ax.set_yticks(range(len(rows)), [words.effect(name) for name, _, _ in rows])
    ax.set_ylim(len(rows) - 0.4, -0.6)
    ax.tick_params(axis="y", length=0, labelcolor=INK)
    ax.annotate(
        "named", (1.0, 1.0), xycoords="axes fraction", xytext=(8, 2), textcoords="offset points", fontsize=9,
        color=MUTED, fontweight="bold", annotation_clip=False,
    )  # fmt: skip
    ax.set_xlabel("effect torque / noise floor at which half are named (95 % interval; arrow: beyond what was tried)")
    grid(ax, "x")
    return ax


@drawn
def shrinkage_figure(score: Score) -> Figure | None:
    """Draw true over claimed shrinkage; None where none was judged."""
    rows = [row for row in score["rows"] if row.get("true") is not None]
    if not rows:
        return None
    figure = new_figure(4.4)
    draw_shrinkage(figure.subplots(), rows)
    found = score["shrinkage"]
    within, middle = percent(found["within_5_points"]["value"]), percent(found["median_true"])
    heading(figure, f"The median correction closes {middle} of the gap; {within} keep their claim to 5 points")
    return figure


def draw_shrinkage(ax: Axes, rows: Sequence[Score]) -> Axes:
    """Draw the part of the gap closed on new motions over the claimed one, low ones as arrows; return ``ax``."""
    claimed = np.array([row["claimed"] for row in rows])
    true = np.array([row["true"] for row in rows])
    low = min(-0.1, max(-0.5, float(true.min())))
    ax.fill_between(
        [low, 1.05], [low - 0.05, 1.0], [low + 0.05, 1.1], color=RULE, alpha=0.6, linewidth=0, label="within 5 points"
    )
    right = np.array([not row["extra"] for row in rows])
    for some, colour, text in ((right, RIGHT, "named right"), (~right, WRONG, "a wrong name")):
        below = some & (true < low)
        ax.plot(claimed[some & ~below], true[some & ~below], "o", color=colour, markersize=5, alpha=0.7, label=text)
        ax.plot(claimed[below], np.full(int(below.sum()), low), "v", color=colour, markersize=6, alpha=0.7)
    whole = int(np.sum((claimed > ALL) & (true > ALL)))
    if whole > 1:
        ax.annotate(
            f"{whole} of {cases(len(rows))} here", (1.0, 1.0), xytext=(-60, -100), textcoords="offset points",
            fontsize=9, color=MUTED, ha="right", va="center", arrowprops={"arrowstyle": "-", "color": MUTED, "lw": 0.7},
        )  # fmt: skip
    ax.legend(frameon=False, loc="upper left")
    _shares(ax, "x", "claimed, on held-out runs")
    _shares(ax, "y", "closed, on new motions of the same arm")
    ax.set_ylim(low - 0.03, 1.06)
    ax.set_xlim(min(0.0, float(claimed.min())) - 0.03, 1.06)
    return ax


def cases(n: int) -> str:
    """Return "1 case", "2 cases"."""
    return f"{n} case{'s' * (n != 1)}"


def _share(ax: Axes, found: Score, y: float, colour: str) -> None:
    low, high = found["ci95"]
    ax.plot([low, high], [y, y], color=colour, linewidth=1.8, solid_capstyle="butt")
    ax.plot(found["value"], y, "o", color=colour, markersize=6)


def _shares(ax: Axes, axis: str, label: str) -> None:
    own = ax.xaxis if axis == "x" else ax.yaxis
    own.set_major_formatter(lambda x, _: percent(round(x, 3)))
    (ax.set_xlim if axis == "x" else ax.set_ylim)(-0.02, 1.02)
    (ax.set_xlabel if axis == "x" else ax.set_ylabel)(label)
    grid(ax, axis)
