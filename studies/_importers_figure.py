"""How far each importer departs from the simulator."""

from __future__ import annotations

from collections.abc import Mapping

from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from stribeck.report.style import COLOUR, drawn, grid, heading, new_figure

PLAIN = {"facecolor": "white", "edgecolor": "none", "pad": 0.8}  # a label stays legible on a dashed line


@drawn
def importers_figure(found: Mapping[str, float | str]) -> Figure:
    """Draw one dot an importer, on a logarithmic axis, with the bounds of both interface types."""
    runs = {name: value for name, value in found.items() if isinstance(value, float) and value > 0.0}
    figure = new_figure(0.9 + 0.28 * len(runs))
    ax = figure.add_subplot()
    colours = ["retuned" if "Exchange" in name else "corrected" for name in runs]
    for row, (value, colour) in enumerate(zip(runs.values(), colours, strict=True)):
        ax.plot([value], [row], "o", color=COLOUR[colour], markersize=5)
        ax.annotate(
            f"{value:.1e}", (value, row), (6, 0), textcoords="offset points", va="center", fontsize=8, bbox=PLAIN
        )
    for bound, colour in ((1e-8, "corrected"), (1e-6, "retuned")):
        ax.axvline(bound, color=COLOUR[colour], linewidth=0.9, linestyle="--")
    ax.set_yticks(range(len(runs)), list(runs))
    ax.set(xscale="log", xlim=(1e-14, 1e-4), xlabel="largest departure of a joint position, rad (dashed: bounds)")
    ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.0e}"))
    ax.invert_yaxis()
    grid(ax, "x")
    stepped = [value for name, value in runs.items() if name.startswith("C, ") or name[-5:-2] == "FMI"]
    heading(figure, f"{len(stepped)} Co-Simulations within {max(stepped):.1g} rad of the simulator over 5 s")
    return figure
