"""Numbers as JSON files give them."""

from __future__ import annotations

import math


def rounded(value: float, digits: int) -> float | None:
    """Return a number at so many significant digits; None, JSON's null, where it is not finite."""
    value = float(value)
    return float(f"{value:.{digits}g}") if math.isfinite(value) else None
