"""The figures behind the claims."""

from __future__ import annotations

from typing import Any

import numpy as np
from _laws import largest_gain
from _paper import constants
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from stribeck.identify.section3.saddle import alphas_by_velocity
from stribeck.identify.tustin_fit import tustin
from stribeck.report.style import COLOUR, MUTED, drawn, grid, heading, new_figure, title

SHADES = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9")


@drawn
def error_figure(rows: list[dict[str, Any]]) -> Figure:
    """Draw joint A's steady error over k: in mrad, and as a share of the error without compensation."""
    figure = new_figure(3.8)
    left, right = figure.subplots(1, 2)
    cases = [(kp, v) for kp in (30.0, 60.0) for v in (0.5, 0.05)]
    for (kp, v), colour in zip(cases, SHADES, strict=False):
        own = [row for row in rows if (row["joint"], row["kp"], row["velocity"]) == ("A", kp, v)]
        k, error = np.array([row["ratio"] for row in own]), np.array([row["error"] for row in own])
        left.plot(k, 1e3 * error, "o-", color=colour, markersize=3.5, linewidth=1.1, label=f"Kp {kp:g}, {v:g} rad/s")
        right.plot(k, error / error[0], "o-", color=colour, markersize=3.5, linewidth=1.1)
    left.legend(frameon=False, fontsize=9)
    left.set(xlabel="k, compensation over friction", ylabel="steady error, mrad")
    right.set(xlabel="k, compensation over friction", ylabel="share of the error without compensation")
    title(left, "In mrad: gain counts, velocity hardly", 4.4)
    title(right, "As a share: one line, 1 - k", 4.4)
    for ax in (left, right):
        ax.axhline(0.0, color=MUTED, linewidth=0.5)
        grid(ax)
    heading(figure, "What compensation leaves does not depend on gain or velocity; what it is worth does")
    return figure


@drawn
def cycle_figure(found: dict[str, Any]) -> Figure:
    """Draw the amplitude of what goes on in regulation over k, one line a kind of loop."""
    figure = new_figure(3.8)
    ax = figure.add_subplot()
    lines = [key for key in found if key.startswith("feed")]
    for key, colour, mark in zip(lines, SHADES, "osD^v", strict=True):
        shape = {"marker": mark, "markersize": 9 if mark == "o" else 5, "fillstyle": "none" if mark == "o" else "full"}
        ax.plot(found["ratios"], 1e3 * np.array(found[key]), color=colour, linewidth=1.1, label=key, **shape)
    ax.axvline(1.0, color=MUTED, linewidth=0.8, linestyle="--")
    ax.set(xlabel="k, compensation over friction", ylabel="amplitude, mrad")
    ax.legend(frameon=False, fontsize=9, loc="center left", bbox_to_anchor=(0.0, 0.32))
    grid(ax)
    heading(
        figure,
        "Feedforward never cycles; feedback does over k = 1, with little damping or noise",
    )
    return figure


@drawn
def stick_slip_figure(found: dict[str, Any]) -> Figure:
    """Draw the stick-slip threshold of joint B over k, and over the damping ratio."""
    figure = new_figure(3.4)
    left, right = figure.subplots(1, 2, sharey=True)
    for ax, values, label in (
        (left, found["by_ratio"], "k of feedforward compensation"),
        (right, found["by_zeta"], "damping ratio"),
    ):
        ax.plot(list(values), list(values.values()), "o-", color=COLOUR["corrected"], linewidth=1.1)
        ax.axhline(0.05, color=MUTED, linewidth=0.8, linestyle="--")
        ax.set(xlabel=label, ylim=(0.0, 0.085))
        grid(ax)
    left.set_ylabel("stick-slip below, rad/s")
    title(left, "Critically damped: the same for every k", 4.4)
    title(right, "Without compensation: damping decides", 4.4)
    heading(figure, "Joint B, Kp 30: ramps at 0.05 rad/s (dashed) stick and slip only far below critical damping")
    return figure


@drawn
def remedy_figure(found: dict[str, Any]) -> Figure:
    """Draw what adaptive and robust compensation leave, and the largest stable gain over the delay."""
    figure = new_figure(3.4)
    axes = figure.subplots(1, 3)
    adaptive = {label.replace(" from k =", ","): 1e3 * value for label, value in found["adaptive"].items()}
    robust = {label: 1e3 * row["error"] for label, row in found["robust"].items()}
    bars = ((axes[0], adaptive, "rms error, mrad"), (axes[1], robust, "largest late error, mrad"))
    for (ax, values, label), colour in zip(bars, SHADES, strict=False):
        ax.barh(list(values), list(values.values()), color=colour)
        ax.set(xscale="log", xlabel=label)
        for row, value in enumerate(values.values()):
            ax.text(value, row, f" {value:.3g}", va="center", fontsize=9)
        ax.set_xlim(0.3 * min(values.values()), 60.0 * max(values.values()))
        ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        ax.xaxis.set_major_locator(LogLocator(numticks=4))
        ax.xaxis.set_minor_locator(NullLocator())
    axes[1].set_xlim(1e-6, 1e5)
    delays = range(5)
    axes[2].plot(delays, [largest_gain(delay) for delay in delays], "o-", color=SHADES[1])
    axes[2].set(xlabel="delay, samples of 12.5 ms", ylabel="largest stable Kp, N m/rad", ylim=(0.0, None))
    axes[2].set_xticks(list(delays))
    for ax, text in zip(axes, ("Adaptive, on a sine", "Robust, in place", "PD, zeta 1"), strict=True):
        title(ax, text, 2.4)
        grid(ax, "y" if ax is axes[2] else "x")
    heading(figure, "The remedies work where they adapt, or run fast; and every delay takes gain away")
    return figure


@drawn
def curve_figure() -> Figure:
    """Draw equation (3), the saddle's velocity over alpha, and curves that bend and reach both torques of the paper."""
    figure = new_figure(3.8)
    left, right = figure.subplots(1, 2)
    C0, C1, C2, alpha = constants("A")
    alphas = np.geomspace(1e-3, C1 / C2, 400)
    saddle = -alpha * np.log(C2 * alpha / C1)
    left.plot(alphas, -alphas * np.log(C2 * alphas / C1), color=COLOUR["corrected"])
    left.axhline(saddle, color=MUTED, linewidth=0.8, linestyle="--")
    left.plot(alphas_by_velocity(saddle, C1, C2), [saddle, saddle], "o", color=COLOUR["as_given"])
    left.set(xlabel="alpha, rad/s", ylabel="velocity of the saddle, rad/s")
    title(left, "Equation (3): two alphas for one saddle", 4.4)
    speed = np.linspace(0.0, 1.0, 2001)
    right.plot(
        speed, tustin(np.array([C0, C1, C2, alpha]), speed), color=COLOUR["corrected"], label="this study's joint A"
    )
    for at, colour in ((1e-3, COLOUR["retuned"]), (7.5e-3, COLOUR["as_given"])):
        right.plot(
            speed, tustin(_through_both(at), speed), color=colour, label=f"through both, saddle at {1e3 * at:g} mrad/s"
        )
    right.plot([0.0, 0.03], [6.25, 6.5], "o", color=COLOUR["measured"], markersize=4)
    right.set(xlabel="velocity, rad/s", ylabel="friction, N m", ylim=(4.0, 32.0))
    right.legend(frameon=False, fontsize=9)
    title(right, "6.25 and 6.5 N m: what it would take", 4.4)
    for ax in (left, right):
        grid(ax)
    heading(figure, "Two alphas at most; and no likely curve passes both of the paper's torques")
    return figure


def _through_both(saddle: float) -> np.ndarray:
    """Return the constants of least C2 with the saddle at a velocity, 6.25 N m at rest and 6.5 at 0.03 rad/s."""
    alpha = saddle * np.geomspace(0.05, 20.0, 4000)
    drop = alpha * np.exp(saddle / alpha) * -np.expm1(-0.03 / alpha)
    needed = np.where(drop < 0.03, 0.25 / np.where(drop < 0.03, 0.03 - drop, 1.0), np.inf)
    k = int(np.argmin(needed))
    C1 = needed[k] * alpha[k] * np.exp(saddle / alpha[k])
    return np.array([6.25 - C1, C1, needed[k], alpha[k]])
