"""The root locus: where the poles of the linear loop go as Kp grows."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from numpy.typing import NDArray

from stribeck.loop.answers import JointAnswer, Locus
from stribeck.report import words
from stribeck.report.cycle_words import gain_unit
from stribeck.report.figures.log_ticks import plain_log
from stribeck.report.numbers import number
from stribeck.report.style import COLOUR, INK, MUTED, drawn, grid, heading, key, new_figure

DOMINANT = 2  # slowest poles, which set what is shown
NEAR = 3.0  # times as fast may others be that are shown whole


@drawn
def locus_figure(answer: JointAnswer) -> Figure | None:
    """Draw one joint's root locus; None where there is none."""
    if answer.locus is None:
        return None
    figure = new_figure(5.4, 8.0)
    ax = figure.add_subplot()
    draw_locus(ax, answer.locus, answer)
    heading(figure, _finding(answer), 8.0)
    return figure


def draw_locus(ax: Axes, locus: Locus, answer: JointAnswer) -> Axes:
    """Draw poles coloured by Kp, those of the loop's own Kp, and the border of stability; return ``ax``.

    A sampled loop's are shown as ln(z) / Ts, so that it reads like a continuous one.
    """
    poles, own = (_continuous(z, locus.sample_time) for z in (locus.poles, locus.own))
    gains = np.repeat(locus.gains, poles.shape[1])
    shades = ax.scatter(
        poles.real.ravel(), poles.imag.ravel(), c=gains, s=9, cmap="viridis_r", norm=LogNorm(), linewidths=0
    )
    ax.plot(own.real, own.imag, "o", color=INK, markerfacecolor="none", markersize=9, zorder=5)
    ax.axvline(0.0, color=COLOUR["as_given"], linewidth=1.4)
    ax.axhline(0.0, color=MUTED, linewidth=0.5, zorder=0)
    reach = _reach(np.abs(poles))
    ax.set(xlim=(-reach, 0.35 * reach), ylim=(-reach, reach), xlabel="real part, 1/s", ylabel="imaginary part, 1/s")
    bar = ax.figure.colorbar(shades, ax=ax, label=f"Kp, {gain_unit(answer)}", pad=0.02)
    plain_log(bar.ax.yaxis)
    key(ax, [("circled: this loop", INK), ("unstable on the right", COLOUR["as_given"])])
    grid(ax, "both")
    return ax


def _reach(size: NDArray[np.float64]) -> float:
    """Return how far to show poles of sizes (G, P), 1/s: the slowest, and the branches that stay near them."""
    size = np.sort(np.where(np.isfinite(size), size, np.inf), axis=1)
    slow = size[:, : min(DOMINANT, size.shape[1])]
    reach = float(np.max(slow[np.isfinite(slow)], initial=1e-6))
    near = size.max(axis=0)[size.max(axis=0) <= NEAR * reach]
    return 1.15 * float(np.max(near, initial=reach))


def _continuous(poles: NDArray[np.complex128], sample_time: float) -> NDArray[np.complex128]:
    """Return poles in 1/s; one at z = 0, where a delay decays at once, as not a number."""
    if sample_time == 0.0:
        return poles
    with np.errstate(divide="ignore", invalid="ignore"):
        rates = np.log(poles) / sample_time
    return np.where(np.abs(poles) > 1e-9, rates, np.nan)


def _finding(answer: JointAnswer) -> str:
    name, top = words.short(answer.joint), answer.kp_max
    unit = gain_unit(answer)
    if top.stability is None:
        return f"{name}: {top.why}"
    share = answer.kp / top.stability
    if share >= 1.0:
        return f"{name}: unstable, Kp {number(answer.kp)} being over the limit of {number(top.stability)} {unit}"
    limit = f"{number(top.stability)} {unit}"
    return f"{name}: the poles leave the stable region at Kp {limit}, {number(1.0 / share)} times this loop's"
