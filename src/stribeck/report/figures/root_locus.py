"""The root locus: where the poles of the linear loop go as Kp grows."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
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
MARGIN = 1.2  # times as far as the crossing is shown
NEAR = 3.0  # times as fast may others be that are shown whole

LEGEND = (
    ("circled: this loop", INK),
    ("unstable on the right", COLOUR["as_given"]),
    ("crosses: largest stable Kp", COLOUR["as_given"]),
)


@drawn
def locus_figure(answer: JointAnswer) -> Figure | None:
    """Draw one joint's root locus; None where there is none."""
    if answer.locus is None:
        return None
    figure = new_figure(5.4, 8.0)
    crossing = crossing_poles(answer.locus, answer.kp_max.stability)
    reach = reach_of(answer.locus)
    far = float(np.max(np.abs(crossing), initial=0.0))
    panels: list[Axes] = list(figure.subplots(1, 2) if far > reach else [figure.add_subplot()])
    for ax, size in zip(panels, (reach, MARGIN * far), strict=False):
        shades = draw_locus(ax, answer.locus, size, crossing)
    if far > reach:
        panels[1].set_ylabel("")
        key(panels[0], [LEGEND[0]])
        key(panels[1], [LEGEND[2]])
    else:
        key(panels[0], LEGEND[:3] if len(crossing) else LEGEND[:2])
    bar = figure.colorbar(shades, ax=panels, label=f"Kp, {gain_unit(answer)}", pad=0.02)
    plain_log(bar.ax.yaxis)
    heading(figure, _finding(answer), 8.0)
    return figure


def draw_locus(ax: Axes, locus: Locus, reach: float, crossing: NDArray[np.complex128]) -> PathCollection:
    """Draw poles coloured by Kp, those of the loop's own Kp, and the border of stability; return the colours.

    A sampled loop's are shown as ln(z) / Ts, so that it reads like a continuous one.
    """
    poles, own = (_continuous(z, locus.sample_time) for z in (locus.poles, locus.own))
    gains = np.repeat(locus.gains, poles.shape[1])
    shades = ax.scatter(
        poles.real.ravel(), poles.imag.ravel(), c=gains, s=9, cmap="viridis_r", norm=LogNorm(), linewidths=0
    )
    ax.plot(own.real, own.imag, "o", color=INK, markerfacecolor="none", markersize=9, zorder=5)
    ax.plot(crossing.real, crossing.imag, "x", color=COLOUR["as_given"], markersize=9, markeredgewidth=2.0, zorder=6)
    ax.axvline(0.0, color=COLOUR["as_given"], linewidth=1.4)
    ax.axhline(0.0, color=MUTED, linewidth=0.5, zorder=0)
    ax.set(xlim=(-reach, 0.35 * reach), ylim=(-reach, reach), xlabel="real part, 1/s", ylabel="imaginary part, 1/s")
    grid(ax, "both")
    return shades


def crossing_poles(locus: Locus, limit: float | None) -> NDArray[np.complex128]:
    """Return where poles (C,) pass the border of stability, at the largest stable Kp, 1/s; empty where none do."""
    beyond = np.flatnonzero(locus.gains >= limit) if limit is not None else np.zeros(0, dtype=int)
    if not len(beyond) or beyond[0] == 0:
        return np.zeros(0, dtype=complex)
    poles = _continuous(locus.poles[beyond[0]], locus.sample_time)
    return np.asarray(1j * poles.imag[np.isfinite(poles) & (poles.real > 0.0)])


def reach_of(locus: Locus) -> float:
    """Return how far to show the poles, 1/s: the slowest, and the branches that stay near them."""
    return _reach(np.abs(_continuous(locus.poles, locus.sample_time)))


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
