"""What a simulation costs, and how far it is off: compiled, in Python, and through which interface."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from stribeck.report.style import COLOUR, drawn, grid, heading, new_figure

PLAIN = {"facecolor": "white", "edgecolor": "none", "pad": 0.8}  # a label stays legible on a grid line


@drawn
def work_and_precision(result: Mapping[str, Any]) -> Figure:
    """Draw departure over CPU time, one point a way to simulate."""
    one = {name: result[name] for name in ("compiled", "python_fixed_steps", "python_events")}
    exact = one["compiled"]["largest_departure_rad"]
    ours, theirs = COLOUR["corrected"], COLOUR["as_given"]
    points = [
        ("compiled,\nbatch driver", result["batch"]["simulation_ms"], exact, ours),
        ("compiled,\nFMPy's calls", one["compiled"]["simulation_ms"], exact, ours),
        ("compiled,\nsimulate_fmu", result["simulate_fmu_ms"], exact, ours),
    ]
    for name, text in (("python_fixed_steps", "fixed steps"), ("python_events", "events")):
        row = one[name]
        points.append((f"PythonFMU3,\n{text}", row["simulation_ms"], row["largest_departure_rad"], theirs))
    figure = new_figure(4.0)
    ax = figure.add_subplot()
    for text, x, y, colour in points:
        ax.plot([x], [y], "o", color=colour, markersize=6)
        label = f"{text}\n{x:.1f} ms" if x < 100.0 else f"{text}\n{x:.0f} ms"
        ax.annotate(label, (x, y), (0, 8), textcoords="offset points", ha="center", fontsize=8.5, bbox=PLAIN)
    ax.set(
        xscale="log", yscale="log", ylim=(1e-12, 1.0), xlim=(0.2 * points[0][1], 8.0 * max(p[1] for p in points)),
        xlabel="CPU time of one simulation of 5 s at 10 ms, ms", ylabel="largest departure, rad",
    )  # fmt: skip
    ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.0e}"))
    grid(ax, "both")
    ratio = result["times_batch"]
    heading(
        figure, f"FMPy's calls cost {ratio['compiled']:.0f} times the batch driver's time, Python inside the FMU "
        f"{ratio['python_events']:.0f} times",
    )  # fmt: skip
    return figure
