"""The branch of cycles: amplitude against k or Kp, exact and by the describing function."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from stribeck.loop.answers import Branch, JointAnswer
from stribeck.loop.ripple import forced_by
from stribeck.report import words
from stribeck.report.cycle_words import at_rest, gain_unit, on_a_ramp, small_unit, when_forced
from stribeck.report.figures.log_ticks import plain_log
from stribeck.report.numbers import number
from stribeck.report.style import COLOUR, INK, MUTED, drawn, grid, heading, key, new_figure

SPREAD = 100.0  # largest over smallest cycle from which a scale of equal steps shows nothing of the small ones


@drawn
def branch_figure(answer: JointAnswer) -> Figure | None:
    """Draw one joint's branch; None where there is none."""
    if answer.branch is None:
        return None
    figure = new_figure(4.4, 8.0)
    ax = figure.add_subplot()
    draw_branch(ax, answer.branch, (at_rest(answer), when_forced(answer)), forced=_forced(answer))
    own = answer.ratio if answer.branch.setting == "k" else answer.kp
    ax.axvline(own, color=INK, linewidth=0.8, linestyle="--")
    _tag(ax, own, "this loop")
    if answer.branch.setting == "k" and answer.k_critical:
        low, high = ax.get_xlim()
        if low < answer.k_critical < high:
            ax.axvline(answer.k_critical, color=COLOUR["retuned"], linewidth=1.2)
            _tag(ax, answer.k_critical, "cycles begin")
    label = "k, compensation over true friction" if answer.branch.setting == "k" else f"Kp, {gain_unit(answer)}"
    ax.set(xlabel=label, ylabel=f"amplitude, {small_unit(answer)}")
    heading(figure, _finding(answer), 8.0)
    return figure


def draw_branch(ax: Axes, branch: Branch, called: tuple[str, str], forced: NDArray[np.bool_]) -> Axes:
    """Draw exact amplitudes, filled where stable, zero at rest, and the predicted ones; return ``ax``.

    Those that are ``forced`` (K,) are no cycles of the loop's own, and of another colour; both are ``called`` so.
    """
    amplitude = np.array([c.amplitude if c.cycles and c.amplitude else 0.0 for c in branch.cycles])
    lost = np.array([c.verdict in ("unbounded", "undetermined") for c in branch.cycles])
    shown = np.where(lost, np.nan, 1e3 * amplitude)
    cycling = np.where(amplitude > 0.0, shown, np.nan)
    unstable = np.array([c.cycles and c.stable is False for c in branch.cycles])
    ax.plot(branch.values, cycling, "-o", color=COLOUR["corrected"], linewidth=1.4, markersize=5)
    ax.plot(branch.values[unstable], cycling[unstable], "o", color=COLOUR["corrected"], markerfacecolor="white")
    ripples = np.where(forced, cycling, np.nan)
    ax.plot(branch.values, ripples, "o", color=COLOUR["partner"], markersize=5, zorder=4)
    resting = ~lost & (amplitude == 0.0)
    ax.plot(branch.values[resting], shown[resting], "s", color=MUTED, markersize=4)
    ax.plot(branch.values, 1e3 * branch.predicted, "--", color=COLOUR["as_given"], linewidth=1.4, marker=".")
    sizes = np.append(shown, 1e3 * branch.predicted)
    top = float(np.max(sizes, where=np.isfinite(sizes), initial=0.0)) or 1.0
    for value, cycle in zip(branch.values, branch.cycles, strict=True):
        if cycle.verdict in ("unbounded", "undetermined"):
            sign = "∞" if cycle.verdict == "unbounded" else "?"
            ax.annotate(sign, (value, 0.94), xycoords=("data", "axes fraction"), ha="center", color=COLOUR["corrected"])
    if branch.setting == "kp":
        ax.set_xscale("log")
        plain_log(ax.xaxis)
    ax.update_datalim([(branch.values.min(), 0.0), (branch.values.max(), 0.0)])  # a sign alone does not widen the axis
    ax.autoscale_view()
    ax.set_ylim(-0.03 * top, 1.15 * top)
    least = float(np.min(sizes, where=np.isfinite(sizes) & (sizes > 0.0), initial=top))
    if top > SPREAD * least:  # down to the smallest cycle in equal steps a decade, rest at nought below it
        ax.set_yscale("symlog", linthresh=0.5 * least, linscale=0.4)
        ax.set_ylim(-0.1 * least, 3.0 * top)
        decades = 10.0 ** np.arange(np.ceil(np.log10(least)), np.floor(np.log10(top)) + 1)
        ax.set_yticks([0.0, *decades], labels=["0", *(f"{value:g}" for value in decades)])
    grows = np.array([cycle.verdict == "unbounded" for cycle in branch.cycles]) & ~np.isfinite(cycling).any()
    lines = (
        (called[0], MUTED, resting),
        ("∞ grows without bound", COLOUR["corrected"], grows),
        ("exact cycle", COLOUR["corrected"], np.isfinite(cycling) & ~forced),
        (called[1], COLOUR["partner"], forced),
        ("describing function", COLOUR["as_given"], np.isfinite(branch.predicted)),
    )
    key(ax, [(name, colour) for name, colour, shown in lines if shown.any()])
    grid(ax, "both")
    return ax


def _forced(answer: JointAnswer) -> NDArray[np.bool_]:
    """Return which motions of a branch (K,) a dither or the arm's waves force."""
    cycles = () if answer.branch is None else answer.branch.cycles
    return np.array([forced_by(cycle.verdict, cycle.period, answer.passes) is not None for cycle in cycles])


def _and(branch: Branch, rests: str) -> str:
    """Return what a loop that cycles without compensation does with it."""
    resting = [value for value, cycle in zip(branch.values, branch.cycles, strict=True) if cycle.verdict == "rest"]
    return f", {rests} at k from {number(min(resting))} to {number(max(resting))}" if resting else " too"


def _tag(ax: Axes, value: float, text: str) -> None:
    ax.annotate(
        text, (value, 0.98), xycoords=("data", "axes fraction"), xytext=(4, 0), textcoords="offset points", va="top",
        color=MUTED, fontsize=9,
    )  # fmt: skip


def _finding(answer: JointAnswer) -> str:
    name, branch = words.short(answer.joint), answer.branch
    assert branch is not None
    forced, lasts = _forced(answer), np.array([cycle.cycles for cycle in branch.cycles])
    cycling, rippling = list(branch.values[lasts & ~forced]), list(branch.values[forced])
    if all(cycle.verdict == "unbounded" for cycle in branch.cycles):
        return f"{name}: grows without bound at every {'k' if branch.setting == 'k' else 'Kp'} shown"
    if branch.setting == "k":
        if answer.k_critical is not None and answer.k_critical > 0.0:
            return f"{name}: cycles begin at k = {number(answer.k_critical, 4)}"
        if answer.k_critical == 0.0:
            rests = "slides steadily" if on_a_ramp(answer) else "rests"
            return f"{name}: cycles without compensation{_and(branch, rests)}"
        return f"{name}: no k makes it cycle"
    unit = gain_unit(answer)
    ripple = f"a {when_forced(answer)} at Kp {_from_to(rippling)} {unit}" if rippling else ""
    if not cycling:
        none = ripple or f"no cycle at Kp {_from_to(list(branch.values))} {unit}"
        return f"{name}: {none}{', and no cycle' if ripple else ''}"
    return f"{name}: cycles at Kp {_from_to(cycling)} {unit}{', ' if ripple else ''}{ripple}"


def _from_to(values: list[float]) -> str:
    low, high = number(min(values)), number(max(values))
    return low if low == high else f"from {low} to {high}"
