"""What a picture of a symptom is drawn from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

Array = np.ndarray


@dataclass(frozen=True)
class Points:
    """Points of one recording, each (M,): ``x``, ``y``, what the ``law`` takes of ``y``, ``side`` (-1, 0 or 1)."""

    x: Array
    y: Array
    law: Array | None
    side: Array


@dataclass(frozen=True)
class Symptom:
    """What an effect looks like: points ``without`` and ``with_it``, their labels, and what ``sides`` (1, -1) mean.

    ``axes`` is ``linear``, ``log x``, ``root x`` (the signed root: low values are spread) or ``log y``; ``joined``
    where points are one line, in their order; ``whole`` where all of the axis is drawn, not only where the law shows.
    """

    without: Points
    with_it: Points
    xlabel: str
    ylabel: str
    sides: tuple[str, str] | None = ("forward", "backward")
    axes: str = "linear"
    joined: bool = False
    whole: bool = False
