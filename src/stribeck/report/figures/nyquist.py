"""The Nyquist plot of a describing function: the linear part, -1/N, and where the two meet."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stribeck.arm import unit_at
from stribeck.loop.answers import JointAnswer, Nyquist
from stribeck.loop.describing import Root
from stribeck.report import words
from stribeck.report.cycle_words import rotation
from stribeck.report.numbers import percent, with_unit
from stribeck.report.style import COLOUR, INK, MUTED, drawn, grid, heading, key, new_figure

LABEL = (0.18, 0.16)  # size of the words at a root, of the axes


@drawn
def nyquist_figure(answer: JointAnswer) -> Figure | None:
    """Draw one joint's Nyquist plot; None where no describing function applies."""
    if answer.nyquist is None:
        return None
    figure = new_figure(5.4, 8.0)
    ax = figure.add_subplot()
    draw_nyquist(ax, answer.nyquist)
    unit = unit_at("rad/(N m s)", answer.kind)
    ax.set(xlabel=f"real part, {unit}", ylabel=f"imaginary part, {unit}")
    heading(figure, _finding(answer), 8.0)
    return figure


def draw_nyquist(ax: Axes, nyquist: Nyquist) -> Axes:
    """Draw W with the compensation's share, -1/N and the roots; return ``ax``."""
    w, inverse = nyquist.response, nyquist.inverse
    reach = 1.15 * float(np.max(np.abs(w))) or 1.0
    ax.plot(w.real, w.imag, color=COLOUR["corrected"], linewidth=1.6)
    ax.plot(inverse.real, inverse.imag, color=COLOUR["as_given"], linewidth=2.2, solid_capstyle="butt")
    low = min(float(w.real.min()), -0.25 * reach)
    high = max(float(w.real.max()), 0.25 * reach)
    ax.set_xlim(low - 0.12 * (high - low), high + 0.12 * (high - low))
    half = 1.1 * max(float(np.abs(w.imag).max()), 0.3 * (high - low))
    ax.set_ylim(-half, half)
    ax.axhline(0.0, color=MUTED, linewidth=0.5, zorder=0)
    ax.axvline(0.0, color=MUTED, linewidth=0.5, zorder=0)
    _arrow(ax, w, half)
    key(ax, [("W(jω) with compensation", COLOUR["corrected"]), ("−1/N(V), V grows leftwards", COLOUR["as_given"])])
    stable = [root for root in nyquist.roots if root.stable]
    told = max(stable or nyquist.roots, key=lambda root: root.amplitude, default=None)  # that the method answers with
    for root in nyquist.roots:
        _mark(ax, nyquist, root, named=root is told)
    grid(ax, "both")
    return ax


def _arrow(ax: Axes, w: np.ndarray, half: float) -> None:
    """Show the way of rising frequency where the curve is longest to follow."""
    k = int(np.argmin(w.imag)) if abs(w.imag.min()) > 0.02 * half else len(w) // 2
    k = min(max(k, 1), len(w) - 2)
    ax.annotate(
        "", (w.real[k + 1], w.imag[k + 1]), (w.real[k - 1], w.imag[k - 1]),
        arrowprops={"arrowstyle": "-|>", "color": COLOUR["corrected"], "mutation_scale": 16},
    )  # fmt: skip


def _mark(ax: Axes, nyquist: Nyquist, root: Root, named: bool) -> None:
    """Draw a root, filled where it is stable; one of them with its numbers."""
    real = float(np.interp(math.log(root.velocity), np.log(nyquist.speed), nyquist.inverse.real))
    size = 8 if named else 6
    ax.plot([real], [0.0], "o", color=INK, markersize=size, markerfacecolor=INK if root.stable else "white", zorder=5)
    if not named:
        return
    kind = "stable" if root.stable else "unstable"
    text = f"{kind}\nω = {with_unit(root.omega, 'rad/s')}\nV = {with_unit(root.velocity, 'rad/s')}"
    across, up = _side(ax, nyquist.response, real)
    ax.annotate(
        text, (real, 0.0), xytext=(12 * across, 10 * up), textcoords="offset points", fontsize=9, color=INK,
        ha="left" if across > 0 else "right", va="bottom" if up > 0 else "top",
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.0, "alpha": 0.85},
    )  # fmt: skip


def _side(ax: Axes, w: np.ndarray, real: float) -> tuple[int, int]:
    """Return the side of a root, right or left and below or above (signs), where its words hide least of W."""
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    x, y = (w.real - real) / (right - left), w.imag / (high - low)
    at = (real - left) / (right - left)
    room = {1: 1.0 - at > LABEL[0], -1: at > LABEL[0]}
    sides = [(across, up) for across in (1, -1) for up in (-1, 1) if room[across]] or [(1, -1)]
    step = np.hypot(np.diff(x, prepend=x[0]), np.diff(y, prepend=y[0]))  # length of curve, however dense its points
    hidden = []
    for across, up in sides:
        beside, above = across * x, up * y
        behind = (beside > 0.0) & (beside < LABEL[0]) & (above > 0.0) & (above < LABEL[1])
        hidden.append(float(step[behind].sum()))
    return sides[int(np.argmin(hidden))]


def _finding(answer: JointAnswer) -> str:
    method, name = answer.methods["describing_function"], words.short(answer.joint)
    if not method.cycle:
        return f"{name}: the curves do not meet: the describing function predicts no cycle"
    assert method.amplitude is not None
    assert method.period is not None
    sized = f"{rotation(answer, method.amplitude)} with a period of {with_unit(method.period, 's')}"
    if method.amplitude_error is None:
        return f"{name}: the curves meet at {sized}, where in truth there is no such cycle"
    off = f"{_off(method.amplitude_error)} off in amplitude and {_off(method.period_error)} in period"
    return f"{name}: the curves meet at {sized}: {off}"


def _off(error: float | None) -> str:
    return "?" if error is None else percent(abs(error))
