"""Friction over velocity: the readings, Section 3's curve by hand, and the fitted ones with their band."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from stribeck.arm import Joint, unit_at
from stribeck.identify.findings import WAYS, Direction, Identification, JointFriction
from stribeck.identify.tustin_fit import NAMES, tustin
from stribeck.report import words
from stribeck.report.numbers import MINUS, number, percent
from stribeck.report.style import COLOUR, drawn, grid, heading, new_figure, title

SOURCE = {
    "curve": "from the readings",
    "runs": "from whole recordings",
    "other direction": "as the other direction",
    "nominal": "as the arm file",
}
LINES: dict[str, dict[str, Any]] = {
    "Section 3": {"color": COLOUR["as_given"], "linewidth": 1.4, "linestyle": (0, (4, 1.5))},
    "IPOPT, readings": {"color": COLOUR["corrected"], "linewidth": 1.6},
    "IPOPT, whole runs": {"color": COLOUR["partner"], "linewidth": 1.1, "linestyle": ":"},
    SOURCE["other direction"]: {"color": COLOUR["noise_floor"], "linewidth": 1.4, "linestyle": "-."},
    SOURCE["nominal"]: {"color": COLOUR["noise_floor"], "linewidth": 1.4},
}
READINGS = "readings"
DOTS: dict[str, Any] = {"marker": ".", "linestyle": "", "color": COLOUR["measured"], "markersize": 4.0, "alpha": 0.55}
MOST_PANELS = 12


@drawn
def friction_curve_figure(found: Identification) -> Figure | None:
    """Draw one panel per joint that moved; None where none did."""
    moved = [(joint, own) for joint, own in zip(found.joints, found.arm.joints, strict=True) if joint.directions]
    joints = [joint for joint, _ in moved[:MOST_PANELS]]
    if not joints:
        return None
    torque, velocity = (unit_at(text, found.nominal.joints[0].kind) for text in ("N m", "rad/s"))
    figure = new_figure(0.9 + 2.9 * len(joints))
    axes = figure.subplots(len(joints), 1, squeeze=False)[:, 0]
    for ax, (joint, own) in zip(axes, moved, strict=False):
        draw_friction_curve(ax, joint, own)
        ax.set_ylabel(f"friction, {torque}")
    left = "; left: backward" if any("backward" in joint.directions for joint in joints) else ""
    axes[-1].set_xlabel(f"velocity, {velocity} (logarithmic, but about zero{left})")
    handles = {str(line.get_label()): line for ax in axes for line in ax.get_lines()}
    shown = [handles[text] for text in (READINGS, *LINES) if text in handles]
    axes[0].legend(handles=shown, ncols=4, loc="lower center", frameon=False, fontsize=9.0)
    heading(figure, _finding(joints))
    return figure


def draw_friction_curve(ax: Axes, joint: JointFriction, own: Joint) -> Axes:
    """Draw one joint's friction against signed velocity, ``own`` as the delivered arm has it; return ``ax``."""
    taken = {name: _taken(own, name) for name in joint.directions}
    slowest, fastest = _range(joint, taken)
    ax.set_xscale("symlog", linthresh=slowest, linscale=0.4)
    for way, name in WAYS.items():
        if name in joint.directions:
            draw_direction(ax, joint.directions[name], taken[name], way, slowest, fastest)
    ends = [way for way, name in WAYS.items() if name in joint.directions]
    ax.set_xlim(-1.15 * fastest if -1 in ends else -0.25 * slowest, 1.15 * fastest if 1 in ends else 0.25 * slowest)
    ax.xaxis.set_major_locator(FixedLocator(_ticks(slowest, 1.15 * fastest, ends)))
    ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}".replace("-", MINUS)))
    ax.xaxis.set_minor_locator(NullLocator())
    ax.set_ylim(*_heights(joint, taken, fastest))
    grid(ax)
    title(ax, f"{words.short(joint.name)}: {_panel(joint)}", width=4.5)
    return ax


def draw_direction(ax: Axes, one: Direction, taken: np.ndarray, way: int, slowest: float, fastest: float) -> None:
    """Draw readings and curves of one direction.

    Parameters
    ----------
    ax : Axes
    one : Direction
    taken : array (4,)
        C0, C1, C2, alpha of the delivered arm: drawn where they are of neither fit.
    way : int
        1 forward, -1 backward.
    slowest, fastest : float
        Ends of the curves' logarithmic part, rad/s.
    """
    speed = np.concatenate([np.linspace(0.0, slowest, 40), np.geomspace(slowest, fastest, 200)])
    if one.points:
        at, torque = ([getattr(point, key) for point in one.points] for key in ("speed", "torque"))
        ax.plot(way * np.array(at), torque, **DOTS, zorder=3, label=READINGS)
    if one.section3 is not None and np.isfinite(one.section3.constants).all() and one.section3.constants[3] > 0.0:
        values = tustin(np.array(one.section3.constants), speed)
        ax.plot(way * speed, values, **LINES["Section 3"], label="Section 3")
    if one.curve.ok:
        level, spread = one.curve.level(speed), 1.96 * one.curve.level_sd(speed)
        ax.fill_between(way * speed, level - spread, level + spread, color=COLOUR["corrected"], alpha=0.2, linewidth=0)
        ax.plot(way * speed, level, **LINES["IPOPT, readings"], label="IPOPT, readings")
    if one.source == "runs" or one.curve.ok:
        ax.plot(way * speed, tustin(one.runs[0], speed), **LINES["IPOPT, whole runs"], label="IPOPT, whole runs")
    label = SOURCE[one.source]
    if label in LINES:
        ax.plot(way * speed, tustin(taken, speed), **LINES[label], label=label)


def _taken(own: Joint, way: str) -> np.ndarray:
    """Return the constants (4,) of one direction."""
    friction = own.friction if way == "forward" else own.backward
    return np.array([getattr(friction, name) for name in NAMES])


def _ticks(slowest: float, fastest: float, ways: Sequence[int]) -> list[float]:
    """Return whole decades on the sides that are shown, and zero."""
    decades = 10.0 ** np.arange(np.ceil(np.log10(slowest)), np.floor(np.log10(fastest) + 1e-9) + 1)
    return [0.0, *(float(way * value) for way in ways for value in decades)]


def _range(joint: JointFriction, taken: Mapping[str, np.ndarray]) -> tuple[float, float]:
    """Return the least and largest speed to show: of the readings; where they are too few, about the bend as well."""
    speeds = [point.speed for one in joint.directions.values() for point in one.points if point.speed > 0.0]
    if speeds and max(speeds) > 1.5 * min(speeds):
        return min(speeds), max(speeds)
    alphas = [float(one.runs[0, 3]) for one in joint.directions.values()]
    alphas += [float(taken[way][3]) for way, one in joint.directions.items() if SOURCE[one.source] in LINES]
    return min([0.2 * min(alphas), *speeds]), max([20.0 * max(alphas), *speeds])


def _heights(joint: JointFriction, taken: Mapping[str, np.ndarray], fastest: float) -> tuple[float, float]:
    """Return the lowest and highest torque to show, so that the bend fills the panel and the legend has its room."""
    levels = [point.torque for one in joint.directions.values() for point in one.points]
    for way, one in joint.directions.items():
        if SOURCE[one.source] in LINES:
            levels += tustin(taken[way], np.array([0.0, 0.1 * fastest, fastest])).tolist()
        if one.source == "runs" or not levels:
            levels += tustin(one.runs[0], np.array([0.0, 0.1 * fastest, fastest])).tolist()
    low, high = min(levels), max(levels)
    return max(0.0, low - 0.5 * (high - low)), high + 0.1 * (high - low) + 1e-12


def _panel(joint: JointFriction) -> str:
    points = [point for one in joint.directions.values() for point in one.points]
    still = sum(point.speed == 0.0 for point in points)
    return f"{len(points) - still} trials of steady sliding, {still} of break-away"


def _finding(joints: Sequence[JointFriction]) -> str:
    said = []
    for joint in joints[:2]:
        for way, one in list(joint.directions.items())[:1]:
            name = words.short(joint.name)
            if one.source == "curve" and one.section3 is not None and one.section3.ok:
                said.append(f"{name}: by hand {_apart(one)} from the fitted curve")
            elif one.source == "curve":
                said.append(f"{name}: fitted, C0 {number(float(one.curve.constants[0]))}; Section 3 fails")
            else:
                said.append(f"{name}, {way}: {SOURCE[one.source]}")
    return "; ".join(said)


def _apart(one: Direction) -> str:
    """Return the rms difference of Section 3's curve from the fitted one, over the velocities read."""
    speed = np.array([point.speed for point in one.points])
    assert one.section3 is not None
    hand, fitted = tustin(np.array(one.section3.constants), speed), one.curve.level(speed)
    return percent(float(np.sqrt(np.mean((hand / fitted - 1.0) ** 2))))
