"""Friction read in contact, with and without the tip force."""

from __future__ import annotations

import numpy as np
from _contact import Pressing
from matplotlib.figure import Figure

from stribeck.report.style import COLOUR, MUTED, drawn, grid, heading, new_figure, title


@drawn
def contact_figure(made: Pressing, applied: np.ndarray, at_tip: np.ndarray, true: np.ndarray) -> Figure:
    """Draw the tip force, and each joint's friction as read with and without it."""
    figure = new_figure(6.0)
    axes = figure.subplots(3, 1, sharex=True)
    axes[0].plot(made.run.t, -made.force[:, 1], color=COLOUR["measured"], linewidth=0.7)
    axes[0].set_ylabel("tip force, N")
    title(axes[0], "Force of the wall on the tip")
    t, applied, at_tip = made.run.t[:-50], applied[:-50], at_tip[:-50]  # the smoothing's edge
    for j, ax in enumerate(axes[1:]):
        ax.plot(t, applied[:, j], color=COLOUR["as_given"], linewidth=1.0, label="applied, less inertial")
        ax.plot(
            t,
            applied[:, j] - at_tip[:, j],
            color=COLOUR["corrected"],
            linewidth=1.0,
            label="less J\u1d40F too",
        )
        ax.axhline(true[j], color=MUTED, linewidth=0.9, linestyle="--", label="Tustin's curve")
        ax.set_ylabel("torque, N m")
        title(ax, f"Joint {'AB'[j]}")
    axes[1].legend(frameon=False, fontsize=9, ncols=3, loc="upper left")
    axes[2].set_xlabel("time, s")
    for ax in axes:
        grid(ax)
    heading(figure, "In contact, the applied torque is friction once the tip force is taken off")
    return figure
