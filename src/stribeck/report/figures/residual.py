"""The residual torque before (re-tuned) and after (corrected): over time, and over velocity or position."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stribeck.gap.result import Diagnosis, Place
from stribeck.report import sentences, words
from stribeck.report.numbers import change, percent
from stribeck.report.signals import Window, sampled, stacked, telling_family, telling_window, thin
from stribeck.report.style import COLOUR, MUTED, RULE, drawn, grid, heading, key, new_figure, title

TELLING = 0.1  # of a squared residual: less is not told as gone


@drawn
def residual_figure(diagnosis: Diagnosis) -> Figure | None:
    """Draw one row per joint; None without held-out traces."""
    window = telling_window(diagnosis)
    if window is None:
        return None
    n = len(diagnosis.joints)
    family = telling_family(diagnosis)
    figure = new_figure(1.0 + 2.2 * n)
    axes = figure.subplots(n, 2, sharex="col", sharey="row", squeeze=False, width_ratios=(1.8, 1.0))
    for j in range(n):
        draw_over_time(axes[j, 0], diagnosis, j, window)
        draw_over_motion(axes[j, 1], diagnosis, j, family)
        title(axes[j, 0], _panel(diagnosis, j), 5.0)
    names = (("re-tuned", COLOUR["retuned"]), ("corrected", COLOUR["corrected"]))
    key(axes[0, 1], names if diagnosis.named else names[:1])
    unit = words.position_unit(diagnosis)
    axes[-1, 0].set_xlabel(f"time since {words.short(window[0].run)} began, s")
    axes[-1, 1].set_xlabel(
        f"velocity, {unit}/s (all held-out)" if family == "velocity" else f"position, {unit} (all held-out)"
    )
    heading(figure, _finding(diagnosis))
    return figure


def draw_over_time(ax: Axes, diagnosis: Diagnosis, joint: int, window: Window) -> Axes:
    """Draw the residual of one joint (index) over a whole run, the telling stretch shaded; return ``ax``."""
    trace, part = window
    ax.axvspan(trace.time[part][0], trace.time[part][-1], color=RULE, alpha=0.45, linewidth=0, zorder=0)
    for model, colour in _models(diagnosis):
        time, values = thin(trace.time, (trace.measured - getattr(trace, model))[:, joint])
        ax.plot(time, values, color=colour, linewidth=0.9)
    ax.set_ylabel(f"residual, {words.torque_unit(diagnosis)}")
    ax.set_xlim(trace.time[0], trace.time[-1])
    _zero(ax)
    return ax


def draw_over_motion(ax: Axes, diagnosis: Diagnosis, joint: int, family: str) -> Axes:
    """Draw the residual of one joint (index) over ``family`` ("velocity" or "position"); return ``ax``."""
    motion = stacked(diagnosis, family)[:, joint]
    measured = stacked(diagnosis, "measured")[:, joint]
    some = sampled(len(motion))
    for model, colour in _models(diagnosis):
        error = measured - stacked(diagnosis, model)[:, joint]
        ax.scatter(motion[some], error[some], s=3.0, color=colour, alpha=0.45, linewidths=0, rasterized=True)
    _zero(ax)
    return ax


def _models(diagnosis: Diagnosis) -> tuple[tuple[str, str], ...]:
    """Return the models to draw; where no effect was named, before and after are one."""
    before = ("retuned", COLOUR["retuned"])
    return (before, ("corrected", COLOUR["corrected"])) if diagnosis.named else (before,)


def _zero(ax: Axes) -> None:
    ax.axhline(0.0, color=MUTED, linewidth=0.5, zorder=1)
    grid(ax)


def _panel(diagnosis: Diagnosis, joint: int) -> str:
    name, changed = words.short(diagnosis.joints[joint]), _changed(diagnosis, joint)
    return name if changed is None else f"{name}: squared residual {change(changed)}"


def _changed(diagnosis: Diagnosis, joint: int) -> float | None:
    """Return the relative change of a joint's squared residual by the named effects; None where there are none."""
    measured = stacked(diagnosis, "measured")[:, joint]
    power = [
        float(np.nanmean((measured - stacked(diagnosis, model)[:, joint]) ** 2)) for model, _ in _models(diagnosis)
    ]
    return None if len(power) == 1 or not power[0] > 0 else power[1] / power[0] - 1.0


def _removed(diagnosis: Diagnosis, place: Place) -> float:
    """Return the part of the squared residual at a place that the named effects remove; 0 where it is not known."""
    for region in diagnosis.regions:
        if (region.joint, region.region) == (place.joint, place.region) and region.rms > 0:
            return 1.0 - (region.rms_corrected / region.rms) ** 2
    return 0.0


def _finding(diagnosis: Diagnosis) -> str:
    if diagnosis.verdict == "no_gap":
        return "What re-tuning leaves cannot be told from noise"
    if not diagnosis.where:
        return "The residual that re-tuning leaves"
    top = max(diagnosis.where, key=lambda place: place.share.value)
    gone = _removed(diagnosis, top)
    if diagnosis.named and gone > TELLING:
        place = f"{words.short(top.joint)} {words.region(top.region)}"
        return f"{words.named(diagnosis)}: {percent(gone)} of the squared residual of {place} is gone"
    relieved = {name: -(_changed(diagnosis, j) or 0.0) for j, name in enumerate(diagnosis.joints)}
    most = max(relieved, key=lambda name: relieved[name])
    if relieved[most] > TELLING:
        less = f"{percent(relieved[most])} of the squared residual of {words.short(most)} is gone"
        there = words.short(top.joint)
        grown = f"; that of {there} has grown" if relieved[top.joint] < -TELLING else f", little of that of {there}"
        return f"{words.named(diagnosis)}: {less}{grown if relieved[top.joint] < TELLING else ''}"
    return sentences.finding(diagnosis)
