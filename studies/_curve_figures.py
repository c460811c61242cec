"""Figures 3 and 5: what Tustin's curve is made of, and one velocity in detail."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from stribeck.identify.tustin_fit import tustin
from stribeck.report.style import COLOUR, MUTED, drawn, grid, heading, new_figure, title
from stribeck.run import Run


@drawn
def tustin_figure(constants: Mapping[str, np.ndarray]) -> Figure:
    """Draw the curves of both joints with their saddle points and their straight parts."""
    figure = new_figure(3.6)
    for ax, (joint, values) in zip(figure.subplots(1, len(constants)), constants.items(), strict=True):
        C0, C1, C2, alpha = values
        speed, saddle = np.linspace(0.0, 0.6, 400), -alpha * np.log(C2 * alpha / C1)
        ax.plot(speed, C0 + C2 * speed, color=MUTED, linewidth=0.9, linestyle="--")
        ax.plot(speed, tustin(values, speed), color=COLOUR["corrected"], linewidth=1.6)
        ax.plot([0.0, saddle], tustin(values, np.array([0.0, saddle])), "o", color=COLOUR["as_given"], markersize=4)
        level = float(tustin(values, np.array([saddle]))[0])
        where = f"saddle, {level:.3g} N m at {saddle:.3g} rad/s"
        ax.annotate(where, (saddle, level), (8, -14), textcoords="offset points", fontsize=9)
        ax.annotate("break-away, C0 + C1", (0.0, C0 + C1), (8, 2), textcoords="offset points", fontsize=9)
        ax.annotate("C0 + C2 v", (0.6, C0 + C2 * 0.6), (-2, -34), textcoords="offset points", ha="right", color=MUTED)
        ax.set(xlabel="velocity, rad/s", ylabel="friction, N m", ylim=(C0 - 0.2 * C1, C0 + 1.15 * C1))
        title(ax, f"{joint}: C2 alpha / C1 = {C2 * alpha / C1:.2g}, condition (2) holds", 4.4)
        grid(ax)
    heading(figure, "Tustin's curve: linear in C0, C1 and C2 once alpha is known")
    return figure


@drawn
def detail_figure(runs: Mapping[str, Run], true: float) -> Figure:
    """Draw joint A's velocity and torque at 0.03 rad/s, one column a gain."""
    figure = new_figure(4.6)
    axes = figure.subplots(2, len(runs), sharex=True, sharey="row", squeeze=False)
    for (upper, lower), (label, run) in zip(axes.T, runs.items(), strict=True):
        t, velocity = run.t - run.t[0], np.diff(run.q[:, 0]) / run.sample_time
        upper.plot(t[1:], velocity, color=COLOUR["measured"], linewidth=0.7)
        upper.axhline(0.03, color=COLOUR["as_given"], linewidth=0.9, linestyle="--")
        lower.plot(t, run.tau[:, 0], color=COLOUR["measured"], linewidth=0.7)
        lower.axhline(true, color=COLOUR["as_given"], linewidth=0.9, linestyle="--")
        upper.set_ylim(-0.02, 0.1)
        lower.set(ylim=(4.0, 7.5), xlabel="time, s")
        title(upper, f"{label}: {run.tau[len(t) // 2 :, 0].mean():.3g} N m in this trial's second half", 4.4)
        for ax in (upper, lower):
            grid(ax)
    axes[0][0].set_ylabel("velocity, rad/s")
    axes[1][0].set_ylabel("torque, N m")
    heading(figure, f"Joint A at 0.03 rad/s: {true:.3g} N m in the mean (dashed), not 6.5; trials differ by some 5 %")
    return figure
