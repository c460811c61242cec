"""What drives a cut along recorded runs: the recorded signals, the command delayed and a late record moved back."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline

from stribeck.identify.conditioning import Conditioned
from stribeck.model.drive import DRIVE, PAST, RATES
from stribeck.model.path import SignalPath

MOVED = ("position", "velocity", "acceleration", "flutter")  # with a record that is late


class Drives:
    """The drives (1 + 19 n, N) of runs under a signal path's effects.

    Parameters
    ----------
    path : SignalPath
    runs : sequence of Conditioned
    """

    def __init__(self, path: SignalPath, runs: Sequence[Conditioned]) -> None:
        self.path, self.runs = path, tuple(runs)
        self._last: tuple[bytes, list[np.ndarray]] = (b"", [])
        self._curves: dict[tuple[int, str, int], tuple[Conditioned, CubicSpline]] = {}

    @cached_property
    def recorded(self) -> list[np.ndarray]:
        """The drive of each run as recorded: made once, for a fit asks for hundreds of residuals."""
        return [_as_recorded(run) for run in self.runs]

    def at(self, delays: np.ndarray) -> list[np.ndarray]:
        """Return the drive of each run; kept until the delays are others, which few candidates change."""
        asked = delays.tobytes()
        if not self._last[1] or self._last[0] != asked:
            self._last = asked, []
            drives = [self.along(run, delays, still) for run, still in zip(self.runs, self.recorded, strict=True)]
            self._last = asked, drives
        return self._last[1]

    def along(self, run: Conditioned, delays: np.ndarray, still: np.ndarray | None = None) -> np.ndarray:
        """Return the drive (1 + 19 n, N), the command delayed and a late record moved back.

        Without delays it is the run's own (``still``, where that is known): not to be written to.
        """
        still = _as_recorded(run) if still is None else still
        ahead: dict[tuple[str, int], float] = {}  # s, by which signals of a joint are to be moved
        for place, delay in zip(self.path.placed, delays, strict=True):
            what = place.effect.delays
            if what is None:
                continue
            for joint in place.joints(self.path.n):
                ahead[what, joint] = ahead.get((what, joint), 0.0) + (-delay if what == "command" else delay)
        if not ahead:
            return still
        drive = still.copy()
        for (what, joint), later in ahead.items():
            for name in ("command",) if what == "command" else MOVED:
                moved, rate = _moved(self._curve(run, name, joint, still), later, run.sample_time)
                drive[_rows(name, self.path.n)][joint] = moved
                drive[_rows(f"{name}_rate", self.path.n)][joint] = rate
            if what != "command":
                asked = run.time + later
                inside = np.clip(asked, run.time[0], run.time[-1])
                drive[_rows("sliding", self.path.n)][joint] = np.interp(asked, run.time, run.sliding[:, joint])
                nearest = np.rint((inside - run.time[0]) / run.sample_time).astype(int)  # which has no slope
                drive[_rows("resting", self.path.n)][joint] = run.resting[nearest, joint]
                spread = _rows("velocity_sd", self.path.n)
                drive[spread][joint] = still[spread][joint][nearest]
        return drive

    def _curve(self, run: Conditioned, name: str, joint: int, still: np.ndarray) -> CubicSpline:
        """Return a recorded signal of one joint as a spline: made once, for a fit moves it a hundred times.

        Its own slopes are the signal's rates, and there is none beyond the record: derivatives by a delay are exact.
        """
        key = id(run), name, joint
        known = self._curves.get(key)
        if known is None or known[0] is not run:
            known = run, CubicSpline(run.time, still[_rows(name, self.path.n)][joint])
            self._curves[key] = known
        return known[1]


def delays_of(path: SignalPath, p: np.ndarray) -> np.ndarray:
    """Return the present value of each effect's delay (0 without one), s."""
    delays = np.zeros(len(path.placed))
    for i, owner in delayers(path).items():
        delays[owner] = p[i]
    return delays


def delayers(path: SignalPath) -> dict[int, int]:
    """Return which effect each parameter belongs to that delays a signal: it changes the drive itself."""
    return {
        i: entry.owner
        for i, entry in enumerate(path.entries)
        if isinstance(entry.owner, int) and entry.name == "time" and path.placed[entry.owner].effect.delays
    }


def _moved(curve: CubicSpline, later: float, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a curve through uniform samples and its slope (N,) a time later than each; beyond its ends it stays."""
    pieces = curve.c.shape[1]
    whole = int(np.floor(np.clip(later / step, -pieces - 1.0, pieces + 1.0)))
    into = later - whole * step  # the same into every piece
    piece = np.arange(pieces + 1) + whole
    x = np.where(piece < 0, 0.0, np.where(piece < pieces, into, step))
    a, b, c, d = curve.c[:, np.clip(piece, 0, pieces - 1)]
    outside = (piece < 0) | (piece + (into > 0.0) > pieces)
    return ((a * x + b) * x + c) * x + d, np.where(outside, 0.0, (3.0 * a * x + 2.0 * b) * x + c)


def _as_recorded(run: Conditioned) -> np.ndarray:
    """Return the drive (1 + 19 n, N) of a run that nothing shifts in time."""
    samples, n = run.position.shape
    out = np.zeros((1 + (len(DRIVE) - 1) * n, samples))
    out[0] = run.told_time
    for name in DRIVE[1:]:
        if name not in RATES:
            values = getattr(run.past if name in PAST else run, name)
            out[_rows(name, n)] = np.broadcast_to(values, (samples, n)).T
    return out


def _rows(name: str, n: int) -> slice:
    """Return the rows of a drive that hold one signal of all joints."""
    begin = 1 + (DRIVE.index(name) - 1) * n
    return slice(begin, begin + n)
