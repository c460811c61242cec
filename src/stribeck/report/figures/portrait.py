"""The phase portrait: how the joint gets to its cycle, and the cycle itself."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stribeck.loop.answers import Analysis
from stribeck.loop.cycle import CycleTrace
from stribeck.report.cycle_words import at_rest, headline, on_a_ramp, small_unit, speed_unit, when_forced
from stribeck.report.style import COLOUR, MUTED, drawn, grid, heading, key, new_figure

MOST = 20_000  # points of a line
WHOLE = 0.98  # of a period, that a trace must cover


@drawn
def portrait_figure(analysis: Analysis, index: int) -> Figure:
    """Draw the phase portrait of one joint, by its place in the analysis."""
    answer = analysis.joints[index]
    figure = new_figure(5.4, 8.0)
    ax = figure.add_subplot()
    approach = _approach(analysis, index)
    ax.plot(1e3 * approach[0], approach[1], color=COLOUR["noise_floor"], linewidth=0.8)
    entries = [("from the loop's own start", COLOUR["noise_floor"])]
    trace = _one_round(analysis, index)
    if trace is not None:
        draw_cycle(ax, trace)
        entries += [("cycle" if answer.forced is None else when_forced(answer), COLOUR["corrected"])]
        if trace.stuck.any():
            entries += [("stuck", COLOUR["as_given"])]
    elif answer.cycle.steady_error is not None:
        ramp = on_a_ramp(answer)
        end = (-1e3 * answer.cycle.steady_error, answer.entry.reference.velocity if ramp else 0.0)
        ax.plot(*end, "o", color=COLOUR["corrected"], markersize=8)
        entries += [(at_rest(answer), COLOUR["corrected"])]
    ax.axhline(0.0, color=MUTED, linewidth=0.5, zorder=0)
    ax.axvline(0.0, color=MUTED, linewidth=0.5, zorder=0)
    ax.set(xlabel=f"position less reference, {small_unit(answer)}", ylabel=f"velocity, {speed_unit(answer)}")
    key(ax, entries)
    grid(ax, "both")
    heading(figure, headline(answer), 8.0)
    return figure


def draw_cycle(ax: Axes, trace: CycleTrace) -> Axes:
    """Draw one period, stuck stretches in another colour; return ``ax``."""
    q, v = 1e3 * np.append(trace.position, trace.position[0]), np.append(trace.velocity, trace.velocity[0])
    stuck = np.append(trace.stuck, trace.stuck[0])
    ax.plot(q, v, color=COLOUR["corrected"], linewidth=1.8)
    ax.plot(np.where(stuck, q, np.nan), np.where(stuck, v, np.nan), "o", color=COLOUR["as_given"], markersize=4)
    return ax


def _one_round(analysis: Analysis, index: int) -> CycleTrace | None:
    """Return one period: the exact one, or the last of the simulation where that is not whole."""
    cycle, motion, j = analysis.joints[index].cycle, analysis.motion, analysis.indices[index]
    if not cycle.cycles or not cycle.period:
        return None
    if cycle.trace is not None and cycle.trace.time[-1] > WHOLE * cycle.period:
        return cycle.trace
    end = motion.motion.filled
    time = motion.motion.t[:end]
    if end == 0 or time[-1] < 2.0 * cycle.period:
        return None
    rows = slice(int(np.searchsorted(time, time[-1] - cycle.period)), end)
    position = motion.motion.q[rows, j] - motion.reference[rows, j]
    return CycleTrace(time[rows], position, motion.motion.dq[rows, j], motion.motion.modes[rows, j] == 0.0)


def _approach(analysis: Analysis, index: int) -> tuple[np.ndarray, np.ndarray]:
    """Return position less reference and velocity, thinned while they move: most of hunting is rest."""
    motion, j = analysis.motion, analysis.indices[index]
    position = (motion.motion.q[:, j] - motion.reference[:, j])[: motion.motion.filled]
    velocity = motion.motion.dq[: motion.motion.filled, j]
    still = (np.diff(position) == 0.0) & (np.diff(velocity) == 0.0)
    rows = np.flatnonzero(np.append(True, ~still) | np.append(~still, True))
    rows = rows[:: max(1, len(rows) // MOST)]
    return position[rows], velocity[rows]
