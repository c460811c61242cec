"""Measured, nominal and corrected torque along the stretch of a held-out run where re-tuning leaves most."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stribeck.gap.answer.closing import closure
from stribeck.gap.answer.stages import FOLLOWED
from stribeck.gap.answer.verdict import AT_FLOOR, EXPLAINED
from stribeck.gap.result import Diagnosis
from stribeck.report import words
from stribeck.report.numbers import number, unit_text
from stribeck.report.signals import Window, telling_window, torque_scale, with_breaks
from stribeck.report.style import COLOUR, MUTED, drawn, end_labels, grid, heading, new_figure, title


@drawn
def measured_figure(diagnosis: Diagnosis) -> Figure | None:
    """Draw one panel per joint, torque against time; None without held-out traces."""
    window = telling_window(diagnosis)
    if window is None:
        return None
    n = len(diagnosis.joints)
    figure = new_figure(0.8 + 2.3 * n)
    axes = figure.subplots(n, 1, sharex=True, squeeze=False)[:, 0]
    for j, ax in enumerate(axes):
        draw_measured(ax, diagnosis, j, window)
    axes[-1].set_xlabel(f"time since {words.short(window[0].run)} began, s")
    heading(figure, _finding(diagnosis, window))
    return figure


def draw_measured(ax: Axes, diagnosis: Diagnosis, joint: int, window: Window) -> Axes:
    """Draw the torques of one joint (index) over a window; return ``ax``."""
    trace, part = window
    lines = (
        ("measured", trace.measured, COLOUR["measured"], "measured", 2.6, "-", 0.35),
        ("nominal", trace.nominal, COLOUR["as_given"], "as given", 1.1, (0, (4, 1.5)), 1.0),
        (
            "corrected",
            trace.corrected,
            COLOUR["corrected" if diagnosis.named else "retuned"],
            words.final(diagnosis),
            1.2,
            "-",
            1.0,
        ),
    )
    ends = []
    for _, values, colour, label, width, dashes, alpha in lines:
        time, torque = with_breaks(trace.time[part], values[part, joint])
        ax.plot(time, torque, color=colour, linewidth=width, linestyle=dashes, alpha=alpha)
        ends.append((float(torque[-1]), label, colour if label != "measured" else MUTED))
    ax.axhline(0.0, color=MUTED, linewidth=0.5, zorder=0)
    ax.set_xlim(trace.time[part][0], trace.time[part][-1])
    ax.set_ylabel(f"{words.effort(diagnosis)}, {words.torque_unit(diagnosis)}")
    grid(ax)
    end_labels(ax, ends, gap=0.1)
    title(ax, _panel(diagnosis, diagnosis.joints[joint]))
    return ax


def _finding(diagnosis: Diagnosis, window: Window) -> str:
    run = words.short(window[0].run, 30)
    if diagnosis.verdict == "no_gap" or words.in_records_alone(diagnosis):
        return f"The re-tuned nominal model follows {run} down to the noise"
    if not diagnosis.named:
        return f"The re-tuned model still misses {run}, and no cause is named"
    named = words.listing([words.effect(name) for name in diagnosis.named])
    left = _left(diagnosis, window)
    if not left and diagnosis.verdict == "partly_explained":
        return f"With {named}, the model follows {run} here; what is left lies elsewhere"
    if not left:
        return f"With {named}, the model follows {run} where re-tuning misses most"
    return f"With {named}, the model still misses {run} by {left} where re-tuning misses most"


def _left(diagnosis: Diagnosis, window: Window) -> str:
    """Return what the corrected model leaves over a window at the joint where that is most; "" where it follows.

    It follows as a gap counts as explained: at the noise floor, or with next to all closed.
    """
    trace, part = window
    floor = torque_scale(diagnosis)
    before, after = (np.nan_to_num(trace.measured - values)[part] for values in (trace.retuned, trace.corrected))
    rms = np.sqrt(np.mean(after**2, axis=0))
    most = np.nanmax(np.abs(trace.measured[part]), axis=0)
    closed = closure(before, after, floor) > EXPLAINED and np.all(rms < FOLLOWED * most)
    if closed or np.max(rms / floor) < AT_FLOOR:
        return ""
    j = int(np.argmax(rms / floor))
    said = f"{number(rms[j])} {unit_text(words.torque_unit(diagnosis))} rms"
    return f"{said} at {words.short(diagnosis.joints[j])}" if len(rms) > 1 else said


def _panel(diagnosis: Diagnosis, joint: str) -> str:
    rms = {stage.stage: stage.torque.get(joint, float("nan")) for stage in diagnosis.stages}
    last = words.last_stage(diagnosis)
    if "as_given" not in rms or last not in rms:
        return words.short(joint)
    unit = unit_text(words.torque_unit(diagnosis))
    return (
        f"{words.short(joint)}: held-out rms error {number(rms['as_given'])} {unit} as given, "
        f"{number(rms[last])} {unit} {words.final(diagnosis)}"
    )
