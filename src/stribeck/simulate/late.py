"""Records of joints that are late by times of their own: simulated in the arm's time, read in the record's.

Where all joints are late alike, that is a command that comes late by as much, and nothing needs to be moved. Where they
are not, what one joint's motion does to another comes when it comes, whatever the record says: the states at the start
are read ahead in the record, the command is on time, and what comes out is put back.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stribeck.identify.conditioning import Conditioned
from stribeck.identify.drives import delays_of
from stribeck.model.path import SignalPath

Floats = NDArray[np.float64]


def lateness(path: SignalPath, p: Floats) -> Floats:
    """Return by how much the position record of each joint (n,) is late, s; negative where it is early."""
    late = np.zeros(path.n)
    for place, time in zip(path.placed, delays_of(path, p), strict=True):
        if place.effect.delays == "position":
            late[list(place.joints(path.n))] += time
    return late


@dataclass(frozen=True)
class LateRecord:
    """A recording of N rows whose joints are late by ``late`` (n,) samples, whole or not."""

    data: Conditioned
    late: Floats

    @property
    def further(self) -> int:
        """Rows beyond a window's end that the arm must go on for: where a record is early, they are in it."""
        return int(np.ceil(max(-self.late.min(), 0.0)))

    def state(self, rows: NDArray[np.int64]) -> tuple[Floats, Floats]:
        """Return position and velocity (W, n) of the arm itself at some rows (W,), at rest where stuck."""
        last = len(self.data.time) - 1
        at = np.clip(rows[:, None] + self.late, 0.0, last)
        moving = np.where(self.data.stuck > 0.5, 0.0, self.data.velocity)
        return _read(self.data.position, at), _read(moving, at)

    def told(self, values: Floats, recorded: Floats, first: NDArray[np.int64], samples: NDArray[np.int64]) -> Floats:
        """Return what the record says in windows of ``samples`` rows (W,) that were simulated with ``further`` more.

        Parameters
        ----------
        values : array (R, n)
            The arm's own, window after window; as many rows more each as there are in the recording.
        recorded : array (N, n)
            What the record says before the arm's motion since a window's start can be in it.
        first, samples : array (W,)
        """
        lengths = np.minimum(samples + self.further, len(self.data.time) - first)
        begins = np.cumsum(lengths) - lengths
        window = np.repeat(np.arange(len(first)), samples)
        row = np.arange(len(window)) - np.repeat(np.cumsum(samples) - samples, samples)
        since = row[:, None] - self.late  # the window's start, in samples
        inside = np.clip(since, 0.0, (lengths - 1)[window][:, None])
        return np.where(since >= 0.0, _read(values, begins[window][:, None] + inside), recorded[first[window] + row])


def _read(values: Floats, at: Floats) -> Floats:
    """Return columns (N, n) read between their rows (M, n)."""
    rows = np.arange(len(values))
    return np.column_stack([np.interp(at[:, j], rows, column) for j, column in enumerate(values.T)])
