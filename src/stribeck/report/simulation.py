"""The figures of a closed-loop simulation: position, error, torque and sticking over time, and torque over velocity."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stribeck.arm import Arm, unit_at
from stribeck.report.numbers import NOTHING, percent
from stribeck.report.style import COLOUR, MUTED, RULE, drawn, grid, heading, key, new_figure, png, range_of, title
from stribeck.simulate.closed import Closed
from stribeck.simulate.metrics import MUCH_LIMITED, measures, share_at_limit

MOST_POINTS = 20_000  # of one line; more than pixels, so that nothing is lost


def write_figures(closed: Closed, arm: Arm, folder: Path) -> None:
    """Write one PNG for each controlled joint, ``motion_<joint number>.png``, into an existing folder."""
    for j in closed.controlled:
        (folder / f"motion_{j + 1}.png").write_bytes(png(motion_figure(closed, arm, j)))


@drawn
def motion_figure(closed: Closed, arm: Arm, joint: int) -> Figure:
    """Draw one joint over time: position with its reference, error, torques; stuck stretches shaded."""
    unit, torque = (unit_at(text, arm.joints[joint].kind) for text in ("rad", "N m"))
    figure = new_figure(7.0)
    axes = figure.subplots(3, 1, sharex=True)
    draw_position(axes[0], closed, joint)
    draw_error(axes[1], closed, joint)
    draw_torque(axes[2], closed, joint)
    drive = "torque" if arm.joints[joint].kind == "revolute" else "force"
    for ax, label in zip(axes, (f"position, {unit}", f"error, m{unit}", f"{drive}, {torque}"), strict=True):
        ax.set_ylabel(label)
        _shade_stuck(ax, closed, joint)
    axes[2].set_xlabel("time, s")
    heading(figure, _finding(closed, arm, joint, unit))
    return figure


def draw_position(ax: Axes, closed: Closed, joint: int) -> Axes:
    """Draw measured position and reference of one joint (index); return ``ax``."""
    rows = _rows(closed)
    time = closed.motion.t[rows]
    ax.plot(time, closed.reference[rows, joint], color=MUTED, linewidth=0.9, linestyle="--")
    ax.plot(time, closed.measured[rows, joint], color=COLOUR["corrected"], linewidth=1.1)
    range_of(ax, np.append(closed.reference[rows, joint], closed.measured[rows, joint]))
    key(ax, (("reference", MUTED), ("measured", COLOUR["corrected"])))
    grid(ax)
    return ax


def draw_error(ax: Axes, closed: Closed, joint: int) -> Axes:
    """Draw the error of one joint (index) in thousandths; return ``ax``."""
    rows = _rows(closed)
    ax.plot(closed.motion.t[rows], 1e3 * closed.error[rows, joint], color=COLOUR["as_given"], linewidth=1.0)
    range_of(ax, 1e3 * closed.error[rows, joint])
    ax.axhline(0.0, color=MUTED, linewidth=0.5)
    title(ax, "reference less measured")
    grid(ax)
    return ax


def draw_torque(ax: Axes, closed: Closed, joint: int) -> Axes:
    """Draw commanded torque and friction of one joint (index); return ``ax``."""
    rows = _rows(closed)
    time = closed.motion.t[rows]
    ax.plot(time, closed.command[rows, joint], color=COLOUR["measured"], linewidth=0.9)
    ax.plot(time, closed.motion.friction[rows, joint], color=COLOUR["retuned"], linewidth=0.9)
    range_of(ax, np.append(closed.command[rows, joint], closed.motion.friction[rows, joint]))
    key(ax, (("command", COLOUR["measured"]), ("friction", COLOUR["retuned"])))
    grid(ax)
    return ax


def _rows(closed: Closed) -> slice:
    return slice(0, closed.motion.filled, max(1, closed.motion.filled // MOST_POINTS))


def _shade_stuck(ax: Axes, closed: Closed, joint: int) -> None:
    rows = _rows(closed)
    stuck = closed.motion.modes[rows, joint] == 0.0
    ax.fill_between(
        closed.motion.t[rows], 0.0, 1.0, where=stuck.tolist(), transform=ax.get_xaxis_transform(), color=RULE,
        alpha=0.45, linewidth=0.0, zorder=0,
    )  # fmt: skip


def _finding(closed: Closed, arm: Arm, joint: int, unit: str) -> str:
    name = arm.names[joint]
    if closed.motion.status != "ok":
        return f"{name}: {closed.motion.status.replace('_', ' ')} after {closed.ended:.4g} s"
    found = measures(closed, joint, len(closed.motion.t) // 2)
    rms, stuck = found["rms_error"], found["stick_fraction"]
    if rms is None or stuck is None or not np.isfinite(rms):
        return name
    size = f"{1e3 * rms:.4g}" if rms > NOTHING else "0"
    said = f"{name}: rms error {size} m{unit} in the second half, stuck {percent(stuck)} of that time (shaded)"
    share = share_at_limit(closed, arm, joint)
    return f"{said}; command at its limit {percent(share)} of the whole time" if share >= MUCH_LIMITED else said
