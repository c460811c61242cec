"""An equation as a small picture, set by matplotlib: no script and no font has to be loaded."""

from __future__ import annotations

from functools import cache

from matplotlib.figure import Figure

from stribeck.report.style import data_uri, drawn, svg


@cache
@drawn
def equation_image(latex: str) -> str:
    """Return a data URI, or "" where the equation (a third party's, say) is beyond matplotlib's mathtext."""
    figure = Figure(figsize=(0.1, 0.1))
    figure.text(0.0, 0.0, f"${latex}$", parse_math=True, fontsize=13.0, color="black")
    try:
        return data_uri(svg(figure, transparent=True), "svg+xml")
    except ValueError:
        return ""
