"""Several motions one after the other: what one recording can hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from stribeck.arm import Arm
from stribeck.gap.experiment.motions import Motion, Reach

Floats = NDArray[np.float64]

PART = 6.0  # s, of each motion
QUICKEST = 0.2  # s, of a move from one motion to the next
PEAK_SPEED, PEAK_ACCELERATION = 1.875, 5.7735  # of a quintic from rest to rest, over length / time and length / time^2


@dataclass(frozen=True)
class Programme:
    """Motions in the order in which they are made, with moves from rest to rest in between.

    Attributes
    ----------
    parts : tuple of Motion
        The motions.
    slower : float
        How many times as long the moves take as speed and acceleration allow.
    """

    parts: tuple[Motion, ...]
    slower: float = 1.0

    def course(self, step: float, reach: Sequence[Reach]) -> Floats:
        """Return the positions (N, n), rad, every ``step`` (s)."""
        t = times(step)
        pieces: list[Floats] = []
        for part in self.parts:
            course = part.course(t, reach)
            if pieces:
                pieces.append(_move(pieces[-1][-1], course[0], step, reach, self.slower))
            pieces.append(course)
        return np.concatenate(pieces)

    def words(self, arm: Arm) -> str:
        """Return the programme in words."""
        return ", then ".join(part.words(arm) for part in self.parts)


def times(step: float) -> Floats:
    """Return the times of one motion (N,), s."""
    return np.asarray(step * np.arange(round(PART / step) + 1, dtype=np.float64))


def _move(start: Floats, end: Floats, step: float, reach: Sequence[Reach], slower: float) -> Floats:
    """Return positions (N, n) strictly between two poses (n,): a quintic, so much slower than the quickest there is."""
    moves = np.flatnonzero(end != start)
    far = np.abs(end - start)[moves]
    speed, acceleration = (np.array([getattr(r, name) for r in reach])[moves] for name in ("speed", "acceleration"))
    quickest = np.maximum(PEAK_SPEED * far / speed, np.sqrt(PEAK_ACCELERATION * far / acceleration))
    count = int(np.ceil(slower * max(QUICKEST, float(quickest.max(initial=0.0))) / step))
    u = np.arange(1, count)[:, None] / count
    return np.asarray(start + (end - start) * u**3 * (10.0 - 15.0 * u + 6.0 * u**2))


def shortest(parts: Sequence[Motion], step: float, reach: Sequence[Reach]) -> tuple[Programme, float]:
    """Return the order of motions that takes the least time, and that time, s."""
    programmes = [Programme(order) for order in permutations(parts)]
    counts = [len(programme.course(step, reach)) for programme in programmes]
    best = int(np.argmin(counts))
    return programmes[best], step * (counts[best] - 1)
