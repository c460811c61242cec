"""The gap, stage by stage: as given, re-tuned, with each effect, and the noise floor that no model can pass."""

from __future__ import annotations

import math

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stribeck.gap.result import Diagnosis
from stribeck.report import words
from stribeck.report.numbers import change, number, percent_interval
from stribeck.report.style import COLOUR, INK, MUTED, RULE, WIDTH, drawn, heading, new_figure, title

Step = tuple[str, float]
ENCODER = "  (the encoder's alone)"


@drawn
def waterfall_figure(diagnosis: Diagnosis) -> Figure | None:
    """Draw one row per joint: torque, and motion where windows could be simulated."""
    if not diagnosis.stages:
        return None
    metrics = ["torque", "motion"] if any(stage.motion for stage in diagnosis.stages) else ["torque"]
    n, rows = len(diagnosis.joints), len(diagnosis.stages)
    figure = new_figure(0.9 + n * (0.75 + 0.34 * rows))
    axes = figure.subplots(n, len(metrics), squeeze=False, sharey="row")
    names = {"torque": words.effort(diagnosis), "motion": "motion"}
    units = {"torque": words.torque_unit(diagnosis), "motion": words.position_unit(diagnosis)}
    for j, joint in enumerate(diagnosis.joints):
        for k, metric in enumerate(metrics):
            steps = [(stage.stage, getattr(stage, metric).get(joint, math.nan)) for stage in diagnosis.stages]
            draw_steps(axes[j, k], steps, line=metric == "torque")
            title(axes[j, k], f"{words.short(joint)}: {names[metric]} gap", 3.5)
            axes[j, k].set_xlabel(f"{units[metric]} rms, held-out" if j == n - 1 else "")
    heading(figure, _finding(diagnosis), WIDTH)
    return figure


def draw_steps(ax: Axes, steps: list[Step], *, line: bool = True) -> Axes:
    """Draw one bar per stage, what the stage took away hatched, the floor as a ``line``; return ``ax``."""
    known = [value for _, value in steps if math.isfinite(value)]
    limit = 1.32 * max(known, default=1.0) or 1.0
    previous = math.nan
    for row, (stage, value) in enumerate(steps):
        _draw_step(ax, row, stage, value, previous if stage != "noise_floor" else math.nan, "" if line else ENCODER)
        previous = value
    floor = dict(steps).get("noise_floor", math.nan)
    if line and math.isfinite(floor):
        ax.axvline(floor, color=COLOUR["noise_floor"], linewidth=1.0, linestyle=(0, (2, 2)))
    ax.set_yticks(range(len(steps)), [words.stage(stage) for stage, _ in steps])
    ax.set_ylim(len(steps) - 0.45, -0.6)
    ax.set_xlim(0.0, limit)
    ax.tick_params(axis="y", length=0, labelcolor=INK, labelsize=9.5)
    ax.spines["left"].set_visible(False)
    ax.locator_params(axis="x", nbins=5)
    return ax


def _draw_step(ax: Axes, row: int, stage: str, value: float, previous: float, floor: str) -> None:
    if not math.isfinite(value):
        ax.annotate(
            "not simulated", (0.01, row), xycoords=("axes fraction", "data"), va="center", color=MUTED, fontsize=9
        )
        return
    ax.barh(row, value, height=0.62, color=COLOUR.get(stage, COLOUR["corrected"]))
    by = floor if stage == "noise_floor" else ""
    if previous > 0:
        part = value / previous - 1.0
        by = f"  ({change(part)})"
        if value < previous:
            ax.barh(
                row,
                previous - value,
                left=value,
                height=0.62,
                facecolor="none",
                edgecolor=RULE,
                hatch="////",
                linewidth=0,
            )
    ax.annotate(
        f"{number(value)}{by}",
        (value, row),
        xytext=(5, 0),
        textcoords="offset points",
        va="center",
        fontsize=9.5,
        color=INK,
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.5},
    )


def _finding(diagnosis: Diagnosis) -> str:
    if diagnosis.verdict == "no_gap":
        return f"Re-tuning alone brings the {words.effort(diagnosis)} gap to the noise floor"
    if not diagnosis.named:
        return "Re-tuning leaves a gap above the noise floor that no known effect explains"
    named = words.named(diagnosis)
    if words.in_records_alone(diagnosis):
        return f"Re-tuning alone reaches the noise floor; {named.lower()} shows in the records themselves"
    if diagnosis.closed is None:
        return f"{named}: the gap before and after"
    closes = "closes" if len(diagnosis.named) == 1 else "close"
    part = percent_interval(diagnosis.closed)
    return f"{named} {closes} {part} of the {words.effort(diagnosis)} gap above the noise floor"
