"""The time trace: the joint's error, velocity and command as simulated from the loop's own start."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stribeck.arm import unit_at
from stribeck.loop.answers import Analysis, JointAnswer
from stribeck.report import words
from stribeck.report.cycle_words import along_ramp, on_a_ramp, rotation, seconds, small_unit, speed_unit
from stribeck.report.style import COLOUR, MUTED, RULE, drawn, grid, heading, new_figure, range_of

MOST = 20_000  # points of a line
PERIODS = 4.0


@drawn
def trace_figure(analysis: Analysis, index: int) -> Figure:
    """Draw error, velocity and command of one joint over time, by its place in the analysis; stuck times shaded."""
    answer = analysis.joints[index]
    torque = unit_at("N m", answer.kind)
    figure = new_figure(6.0, 8.0)
    axes = figure.subplots(3, 1, sharex=True)
    rows, motion, j = _rows(analysis, answer), analysis.motion, analysis.indices[index]
    time = motion.motion.t[rows]
    columns = (1e3 * motion.error[rows, j], motion.motion.dq[rows, j], motion.command[rows, j])
    colours = (COLOUR["as_given"], COLOUR["corrected"], COLOUR["measured"])
    labels = (f"error, {small_unit(answer)}", f"velocity, {speed_unit(answer)}", f"command, {torque}")
    for ax, values, colour, label in zip(axes, columns, colours, labels, strict=True):
        ax.plot(time, values, color=colour, linewidth=1.0)
        ax.set_ylabel(label)
        range_of(ax, values)
        ax.axhline(0.0, color=MUTED, linewidth=0.5, zorder=0)
        _shade(ax, time, motion.motion.modes[rows, j] == 0.0)
        grid(ax)
    axes[2].set_xlabel("time, s")
    if len(time) > 1:  # a motion may be beyond all bounds at once
        axes[2].set_xlim(time[0], time[-1])
    heading(figure, _finding(analysis, answer), 8.0)
    return figure


def _rows(analysis: Analysis, answer: JointAnswer) -> slice:
    """Return the loop file's own duration, and a few periods at least."""
    motion = analysis.motion.motion
    shown = max(analysis.duration, PERIODS * (answer.cycle.period or 0.0))
    end = int(np.searchsorted(motion.t[: motion.filled], shown, side="right"))
    return slice(0, end, max(1, end // MOST))


def _shade(ax: Axes, time: np.ndarray, stuck: np.ndarray) -> None:
    ax.fill_between(
        time, 0.0, 1.0, where=stuck.tolist(), transform=ax.get_xaxis_transform(), color=RULE, alpha=0.45,
        linewidth=0.0, zorder=0,
    )  # fmt: skip


def _finding(analysis: Analysis, answer: JointAnswer) -> str:
    name, motion = words.short(answer.joint), analysis.motion
    if motion.motion.status != "ok":
        return f"{name}: {motion.motion.status.replace('_', ' ')} after {seconds(motion.ended)}"
    index = analysis.indices[analysis.joints.index(answer)]
    half, end = motion.motion.filled // 2, motion.motion.filled
    late = motion.error[half:end, index]
    shaded = "; stuck times shaded" if (motion.motion.modes[:end, index] == 0.0).any() else ""
    if answer.cycle.cycles:
        shown = float(motion.motion.t[_rows(analysis, answer).stop - 1])
        part = f" of {seconds(motion.ended)}, the first {seconds(shown)} shown" if shown < 0.99 * motion.ended else ""
        swing = rotation(answer, 0.5 * float(np.ptp(late)))
        return f"{name}: the error swings ±{swing} in the second half{part}{shaded}"
    if answer.cycle.verdict == "rest" and on_a_ramp(answer):
        place = along_ramp(answer, float(late[-1]))
        return f"{name}: slides along its ramp, {place} after {seconds(motion.ended)}{shaded}"
    return f"{name}: the error ends at {rotation(answer, float(late[-1]))}{shaded}"
