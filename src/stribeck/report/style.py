"""How every figure looks: colours, type, and the few helpers that keep labels readable.

Colours are those of Okabe & Ito (2008), told apart by colour-blind readers; one colour means one thing throughout.
"""

from __future__ import annotations

import base64
import io
import textwrap
import warnings
from collections.abc import Callable, Sequence
from functools import wraps
from typing import Any, ParamSpec, TypeVar

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

INK = "#1f2328"
MUTED = "#59636e"
RULE = "#d0d7de"
COLOUR = {
    "measured": "#1f2328",
    "as_given": "#d55e00",
    "retuned": "#e69f00",
    "corrected": "#0072b2",
    "noise_floor": "#8c959f",
    "partner": "#009e73",
}
STILL = 1e-9  # of a signal, or of its unit where that is less: a smaller change is rounding
WIDTH = 9.0  # inches; with DPI, 1440 pixels
DPI = 160

_RC: Any = {  # matplotlib types its keys one by one, differently in each version
    "text.usetex": False,
    "text.parse_math": False,  # names come from files; "$" is a character
    "font.family": ["DejaVu Sans"],
    "font.size": 10.0,
    "axes.titlesize": 10.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.titlepad": 8.0,
    "axes.labelsize": 10.0,
    "axes.labelcolor": MUTED,
    "axes.edgecolor": MUTED,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.unicode_minus": True,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelsize": 9.0,
    "ytick.labelsize": 9.0,
    "text.color": INK,
    "figure.facecolor": "white",
    "figure.dpi": 100.0,
    "savefig.dpi": DPI,
    "savefig.facecolor": "white",
    "svg.fonttype": "path",
    "svg.hashsalt": "stribeck",
}

P = ParamSpec("P")
R = TypeVar("R")


def drawn(draw: Callable[P, R]) -> Callable[P, R]:
    """Let ``draw`` run under this style, whatever the user's matplotlibrc says, and leave that as it was."""

    @wraps(draw)
    def styled(*args: P.args, **kwargs: P.kwargs) -> R:
        with matplotlib.rc_context(_RC):
            return draw(*args, **kwargs)

    return styled


def new_figure(height: float, width: float = WIDTH) -> Figure:
    """Return an empty figure of that size (inches) that lays itself out and needs no display."""
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


@drawn
def png(figure: Figure, box: Bbox | None = None) -> bytes:
    """Return the figure as PNG, trimmed so that nothing is cut off; the same figure gives the same bytes.

    ``box`` (inches) is what there is to show, where that is known.
    """
    trim: Any = "tight" if box is None else box.padded(0.12)
    buffer = io.BytesIO()
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from")  # a name in a script that the font lacks
        figure.savefig(buffer, format="png", bbox_inches=trim, pad_inches=0.12, metadata={"Software": None})
    return buffer.getvalue()


@drawn
def svg(figure: Figure, transparent: bool = False, box: Bbox | None = None) -> bytes:
    """Return the figure as SVG, text as outlines: it looks the same everywhere and loads nothing; ``box`` as above."""
    trim: Any = "tight" if box is None else box.padded(0.05)
    buffer = io.BytesIO()
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from")
        figure.savefig(
            buffer, format="svg", bbox_inches=trim, pad_inches=0.05, metadata={"Date": None}, transparent=transparent
        )
    return buffer.getvalue()


@drawn
def png_and_svg(figure: Figure) -> tuple[bytes, bytes]:
    """Return both; layout and edges, which take longer than drawing, are worked out once and kept."""
    figure.set_dpi(DPI)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from")
        figure.draw_without_rendering()
        figure.set_layout_engine(None)
        box = figure.get_tightbbox()
        return png(figure, box), svg(figure, box=box)


def data_uri(content: bytes, kind: str) -> str:
    """Return image bytes as a data URI; ``kind`` is "png" or "svg+xml"."""
    return f"data:image/{kind};base64,{base64.b64encode(content).decode('ascii')}"


def heading(figure: Figure, text: str, width: float = WIDTH) -> None:
    """Put the finding above all panels, wrapped to the figure."""
    figure.suptitle(_wrap(text, width, 12.0), x=0.01, ha="left", fontsize=12.0, fontweight="bold")


def finding_of(figure: Figure) -> str:
    """Return the finding that :func:`heading` put there, on one line; "" without one."""
    return " ".join(figure.get_suptitle().split())


def title(ax: Axes, text: str, width: float = WIDTH) -> None:
    """Put a finding above one panel of that width (inches)."""
    ax.set_title(_wrap(text, width, 10.5))


def key(ax: Axes, entries: Sequence[tuple[str, str]]) -> None:
    """Name the colours (text, colour) above the right end of a panel, in place of a legend."""
    place: dict[str, Any] = {"xy": (1.0, 1.0), "xycoords": "axes fraction", "xytext": (0.0, 8.0)}
    for text, colour in reversed(entries):
        words = ax.annotate(
            text, **place, textcoords="offset points", ha="right", va="bottom", color=colour, fontsize=9.5,
            fontweight="bold",
        )  # fmt: skip
        place = {"xy": (0.0, 0.0), "xycoords": words, "xytext": (-18.0, 0.0)}


def grid(ax: Axes, axis: str = "y") -> None:
    """Draw faint lines to read values by, behind the data."""
    ax.set_axisbelow(True)
    ax.grid(True, axis=axis, color=RULE, linewidth=0.6)  # type: ignore[arg-type]


def range_of(ax: Axes, values: np.ndarray) -> None:
    """Give a panel whose signal stands still a range in which it is a line, not rounding: 1 about it at least."""
    known = values[np.isfinite(values)]
    if len(known) and np.ptp(known) <= STILL * max(1.0, float(np.abs(known).max())):
        middle = float(np.mean(known))
        ax.set_ylim(middle - max(1.0, 0.1 * abs(middle)), middle + max(1.0, 0.1 * abs(middle)))


def end_labels(ax: Axes, labels: Sequence[tuple[float, str, str]], gap: float = 0.09) -> None:
    """Write (y, text, colour) at the right edge, at least ``gap`` of the axis apart, each tied to its line's end."""
    low, high = ax.get_ylim()
    rows = sorted(((y - low) / (high - low), text, colour) for y, text, colour in labels if np.isfinite(y))
    places = _spread([row[0] for row in rows], gap)
    for (end, text, colour), place in zip(rows, places, strict=True):
        ax.annotate(
            text,
            xy=(1.0, end),
            xytext=(1.03, place),
            xycoords="axes fraction",
            textcoords="axes fraction",
            va="center",
            color=colour,
            fontsize=9.0,
            fontweight="bold",
            arrowprops={
                "arrowstyle": "-",
                "color": colour,
                "linewidth": 0.7,
                "shrinkA": 1.0,
                "shrinkB": 0.0,
                "relpos": (0.0, 0.5),
            },
        )


def _spread(wanted: list[float], gap: float) -> list[float]:
    """Return places in the same order at least ``gap`` apart, within 0..1 where they fit, near those wanted."""
    places: list[float] = []
    for want in wanted:
        places.append(max(want, places[-1] + gap) if places else max(want, 0.0))
    over = max(places[-1] - 1.0, 0.0) if places else 0.0
    for k in reversed(range(len(places))):
        top = 1.0 if k == len(places) - 1 else places[k + 1] - gap
        places[k] = min(places[k], top) if over else places[k]
    return places


def _wrap(text: str, width: float, size: float) -> str:
    per_inch = 72.0 / (0.59 * size)  # a bold letter is about 0.59 of its size wide
    return "\n".join(textwrap.wrap(text, max(int(width * per_inch), 20), break_on_hyphens=False))
