"""Figures of the studies of the paper."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from stribeck.report.style import MUTED, drawn, grid, heading, new_figure, title
from stribeck.run import Run

SHADES = ("#0072b2", "#d55e00", "#009e73", "#cc79a7")


@drawn
def break_away_figure(runs: Mapping[str, Sequence[Run]], result: Mapping[str, Any]) -> Figure:
    """Draw velocity against applied torque of four trials a joint, as Figure 4 does."""
    figure = new_figure(3.6)
    for ax, (joint, trials) in zip(figure.subplots(1, len(runs)), runs.items(), strict=True):
        j, found = "AB".index(joint), result[joint]
        for run, colour in zip(trials, SHADES, strict=False):
            velocity = np.diff(run.q[:, j]) / run.sample_time
            ax.plot(run.tau[:-1, j], velocity, color=colour, linewidth=1.1)
        ax.axvline(found["true"], color=MUTED, linewidth=0.8, linestyle="--")
        ax.set(xlim=(0.8 * found["true"], None), ylim=(-0.05, 1.0), xlabel="applied torque, N m")
        ax.set_ylabel("velocity, rad/s")
        title(ax, f"{joint}: mean of ten {found['read_back']['mean']:.3g} N m, true {found['true']:.3g}", 4.4)
        grid(ax)
    seen = [result[joint]["bias_at_1_times_the_rate"]["first_seen"] for joint in runs]
    heading(figure, f"Break-away, four trials each: the velocity is seen {100 * max(seen):.1f} % too late at most")
    return figure
