"""How many times faster than real time each simulation runs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from stribeck.report.style import COLOUR, drawn, grid, heading, new_figure


@drawn
def speed_figure(result: Mapping[str, Any]) -> Figure:
    """Draw one bar a simulator, on a logarithmic axis."""
    ours = float(result["times_real_time"])
    bars = {"this engine": ours, "scipy solve_ivp, events": ours / result["scipy"]["times_slower"]}
    if isinstance(result["mujoco"], Mapping):
        bars["MuJoCo, frictionloss"] = ours / result["mujoco"]["times_slower"]
    figure = new_figure(2.4)
    ax = figure.add_subplot()
    ax.barh(list(bars), list(bars.values()), color=[COLOUR["corrected"], *[COLOUR["noise_floor"]] * 2][: len(bars)])
    for row, value in enumerate(bars.values()):
        ax.text(value, row, f" {value:,.0f}" if value > 100.0 else f" {value:.2g}", va="center", fontsize=9)
    ax.axvline(200.0, color=COLOUR["as_given"], linewidth=0.9, linestyle="--")
    ax.set(
        xscale="log",
        xlim=(0.3 * min(bars.values()), 4.0 * ours),
        xlabel="times real time (dashed: 200), two joints at 80 Hz",
    )
    ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    ax.invert_yaxis()
    grid(ax, "x")
    heading(figure, f"{ours:,.0f} times real time in one thread, events included")
    return figure
