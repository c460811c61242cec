"""Plain numbers along logarithmic axes: matplotlib's own ticks are formulas, which the style does not set."""

from __future__ import annotations

import math

from matplotlib.axis import Axis
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

MOST_DECADES = 1.3  # with so few or less, 2 and 5 are labelled too


def plain_log(axis: Axis) -> None:
    """Label a logarithmic axis 1, 2, 5, 10, ... or by decades alone where it is long."""
    low, high = axis.get_view_interval()
    short = low > 0.0 and math.log10(high / low) <= MOST_DECADES * 2.0
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if short else (1.0,)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())
