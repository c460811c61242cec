"""The filtered residual of a signal path over recorded runs, and its Jacobian."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline

from stribeck.identify.conditioning import Conditioned, emphasised
from stribeck.model.cut import CHUNK, DRIVE, RATES, Cut
from stribeck.model.path import SignalPath

SAMPLES = 40_000  # evaluated at a time: bounds the memory of the Jacobian


class Residual:
    """Residual torque of a path along conditioned runs, in N m of command, at the analysis samples.

    Parameters
    ----------
    path : SignalPath
    runs : sequence of Conditioned
        The rows of all results are those of the runs, one after the other.
    columns : sequence of int or None
        Parameters whose derivatives are wanted; those that a fit may move (prior deviation over 0) where None.
    """

    def __init__(self, path: SignalPath, runs: Sequence[Conditioned], columns: Sequence[int] | None = None) -> None:
        self.path, self.runs = path, tuple(runs)
        free = [i for i, entry in enumerate(path.entries) if entry.sd > 0.0]
        self.columns = tuple(free if columns is None else columns)
        steps = {round(run.sample_time, 9): run.sample_time for run in runs}
        self._cuts = {key: Cut(path, step, self.columns) for key, step in steps.items()}

    def _cut(self, run: Conditioned) -> Cut:
        return self._cuts[round(run.sample_time, 9)]

    @cached_property
    def rows(self) -> int:
        """Number of analysis samples."""
        return sum(len(run.analysis_index) for run in self.runs)

    def __call__(self, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the residual (M, n) and its Jacobian (M, n, columns) at physical parameter values (p,)."""
        parts = [self._one(run, p) for run in self.runs]
        return np.concatenate([r for r, _ in parts]), np.concatenate([jacobian for _, jacobian in parts])

    def _one(self, run: Conditioned, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        cut, n, width = self._cut(run), self.path.n, len(self.columns)
        delays = self._delays(p)
        drive = self._drive(run, delays)
        states = self._states(cut, drive, p, delays)
        outputs = []
        half = len(run.taps)
        for begin in range(0, len(run.time), SAMPLES):
            lo, hi = max(0, begin - half), min(len(run.time), begin + SAMPLES + half)
            values = np.asarray(cut.evaluate(drive[:, lo:hi], states[:, lo:hi], p, delays)).T
            outputs.append(_keep(run, values, lo, begin, min(begin + SAMPLES, len(run.time))))
        merged = np.concatenate(outputs)
        return merged[:, :n], merged[:, n:].reshape(len(merged), width, n).transpose(0, 2, 1)

    def stages(self, run: Conditioned, p: np.ndarray) -> dict[str, np.ndarray]:
        """Return the unfiltered residual and stage torques of one run, each (N, n), N m of command."""
        cut, n = self._cut(run), self.path.n
        delays = self._delays(p)
        drive = self._drive(run, delays)
        states = self._states(cut, drive, p, delays)
        residual, stages = cut.balance(drive, states, p, delays)
        names = ("actuator", "rotor", "load", "friction")
        out = {name: stages.full()[i * n : (i + 1) * n].T for i, name in enumerate(names)}
        return {"residual": residual.full().T, **out}

    def _delays(self, p: np.ndarray) -> np.ndarray:
        """Return the present value of each effect's delay (0 without one), s."""
        delays = np.zeros(len(self.path.placed))
        for i, entry in enumerate(self.path.entries):
            owner = entry.owner
            if isinstance(owner, int) and entry.name == "time" and self.path.placed[owner].effect.delays:
                delays[owner] = p[i]
        return delays

    def states(self, run: Conditioned, p: np.ndarray) -> np.ndarray:
        """Return the states (N, nx) of the path along one run; the order is that of ``path.state_names``."""
        cut, delays = self._cut(run), self._delays(p)
        return self._states(cut, self._drive(run, delays), p, delays)[: cut.nx].T

    def _drive(self, run: Conditioned, delays: np.ndarray) -> np.ndarray:
        """Return the drive (1 + 9 n, N), the command delayed and a late record moved back."""
        motion = ("position", "velocity", "acceleration")
        signals = {name: getattr(run, name) for name in (*motion, "command")}
        signals |= {name: np.zeros_like(run.command) for name in RATES}
        signals["velocity_sd"] = np.broadcast_to(run.velocity_sd, run.position.shape)
        for k, place in enumerate(self.path.placed):
            if place.effect.delays == "command":
                _shift(signals, run.time, -delays[k], place.joint, ("command",))
            elif place.effect.delays == "position":
                _shift(signals, run.time, delays[k], place.joint, motion)
        return np.concatenate([run.time[:, None], *(signals[name] for name in DRIVE[1:])], axis=1).T

    def _states(self, cut: Cut, drive: np.ndarray, p: np.ndarray, delays: np.ndarray) -> np.ndarray:
        """Return states and sensitivities (nx (1 + active), N) along one run."""
        samples = drive.shape[1]
        width = cut.nx * (1 + len(cut.active))
        if width == 0:
            return np.zeros((0, samples))
        state = cut.begin(drive[:, 0], p, delays).full()
        out = np.empty((width, samples))
        out[:, :1] = state
        drive = drive.copy()
        rows = slice(1 + 3 * cut.n, 1 + 4 * cut.n)
        drive[rows] = emphasised(drive[rows].T).T  # between samples the command runs straight, which droops
        many_p, many_delays = np.repeat(p[:, None], CHUNK, axis=1), np.repeat(delays[:, None], CHUNK, axis=1)
        for begin in range(0, samples - 1, CHUNK):
            index = np.minimum(np.arange(begin, begin + CHUNK + 1), samples - 1)
            chunk = drive[:, index]
            after = cut.follow(out[:, begin], chunk[:, :-1], chunk[:, 1:], many_p, many_delays).full()
            stop = min(begin + CHUNK, samples - 1)
            out[:, begin + 1 : stop + 1] = after[:, : stop - begin]
        return out


def _keep(run: Conditioned, values: np.ndarray, lo: int, begin: int, end: int) -> np.ndarray:
    """Return the filtered rows whose analysis sample lies in [begin, end), from values that start at lo."""
    wanted = run.analysis_index
    wanted = wanted[(wanted >= begin) & (wanted < end)]
    if len(wanted) == 0:
        return np.zeros((0, values.shape[1]))
    half = len(run.taps) // 2
    return run.filtered(values[wanted[0] - half - lo : wanted[-1] + half + 1 - lo])


def _shift(signals: dict[str, np.ndarray], time: np.ndarray, ahead: float, joint: int, names: Sequence[str]) -> None:
    """Replace one joint's signals by those of a later time (s), and give their rates there.

    The rates are the splines' own slopes, so that derivatives by the shift are exact.
    """
    later = np.clip(time + ahead, time[0], time[-1])
    for name in names:
        curve = CubicSpline(time, signals[name][:, joint])
        for key, order in ((name, 0), (f"{name}_rate", 1)):
            signals[key] = signals[key].copy()
            signals[key][:, joint] = curve(later, order)
