"""The filtered residual of a signal path over recorded runs, and its Jacobian."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from copy import copy
from functools import cached_property
from typing import Any, TypeVar

import casadi as ca
import numpy as np

from stribeck.identify.conditioning import Conditioned
from stribeck.identify.drives import Drives, delayers, delays_of
from stribeck.identify.inertia import MovedInertia
from stribeck.identify.machine import Abreast, Kept, Machine, machine_of
from stribeck.model.cut import Cut
from stribeck.model.path import SignalPath

Found = TypeVar("Found")

SAMPLES = 40_000  # evaluated at a time: bounds the memory of the Jacobian
SAME_STEP = 1e-4  # of it, by which the steps of two runs may differ and still be one: so much do their clocks, too


class Residual:
    """Residual torque of a path along conditioned runs, in N m of command, at the analysis samples.

    None is left at a joint that a run holds by a brake; an effect that a run is without is null along it. At a joint
    that a run does not drive it is told for the inertia of the arm file: else smaller masses would leave less of
    everything, noise and gap alike.

    Parameters
    ----------
    path : SignalPath
    runs : sequence of Conditioned
        The rows of all results are those of the runs, one after the other.
    columns : sequence of int or None
        Parameters whose derivatives are wanted; those that a fit may move (prior deviation over 0) where None.
    known : sequence of array (N, nx), or None
        States along each run at the only values that all other parameters will have: they are taken as they are where
        the path has no further state and none of the ``columns`` changes one.
    observe : bool
        Whether links and bristles at rest are corrected by the residual (:mod:`stribeck.model.observer`,
        :mod:`stribeck.model.resting`).
    """

    dear = False
    """Whether derivatives cost several times as much as :meth:`value`, and are secants: not quite those of the cost."""

    def __init__(
        self,
        path: SignalPath,
        runs: Sequence[Conditioned],
        columns: Sequence[int] | None = None,
        known: Sequence[np.ndarray] | None = None,
        *,
        observe: bool = True,
    ) -> None:
        self.path, self.runs, self.known, self.observe = path, tuple(runs), known, observe
        free = [i for i, entry in enumerate(path.entries) if entry.sd > 0.0]
        self.columns = tuple(free if columns is None else columns)
        self._inertia, self._drives = MovedInertia(path), Drives(path, self.runs)
        self._moving = self.columns if self.columns and not delayers(path).keys() & set(self.columns) else None
        self._machines: dict[float, Machine] = {}
        self._abreast: dict[Hashable, Abreast] = {}
        self._kept: dict[Hashable, Kept] = {}

    def _machine(self, run: Conditioned) -> Machine:
        for step, machine in self._machines.items():
            if abs(run.sample_time - step) < SAME_STEP * step:
                return machine
        machine = machine_of(self.path, run.sample_time, self._derived, observe=self.observe, moving=self._moving)
        return self._machines.setdefault(run.sample_time, machine)

    @property
    def _derived(self) -> tuple[int, ...]:
        """Parameters whose derivatives the machine gives."""
        return self.columns

    @cached_property
    def rows(self) -> int:
        """Number of analysis samples."""
        return sum(len(run.analysis_index) for run in self.runs)

    def along(self, runs: Sequence[Conditioned]) -> Residual:
        """Return the same residual along other runs; what was compiled for a sample time is used again."""
        other = copy(self)
        for what in ("rows", "reuses"):
            other.__dict__.pop(what, None)
        other.runs, other.known, other._abreast, other._kept = tuple(runs), None, {}, {}
        other._drives = Drives(self.path, other.runs)
        return other

    def __call__(self, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the residual (M, n) and its Jacobian (M, n, columns) at physical parameter values (p,)."""
        delays = delays_of(self.path, p)
        drives = self._drives.at(delays)
        states = self._states(self.runs, drives, p, delays)
        parts = [self._one(*one, p, delays) for one in zip(self.runs, drives, states, strict=True)]
        return np.concatenate([r for r, _ in parts]), np.concatenate([jacobian for _, jacobian in parts])

    def value(self, p: np.ndarray) -> np.ndarray:
        """Return the residual (M, n) alone."""
        return self(p)[0]

    def _one(
        self, run: Conditioned, drive: np.ndarray, states: np.ndarray, p: np.ndarray, delays: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        n = self.path.n
        outputs = []
        half, machine, p = len(run.taps), self._machine(run), self.path.without(run.without, p)
        known = self._kept.setdefault(run.without, Kept())
        kept = known.along(machine, drive, p, delays) if len(run.time) <= SAMPLES else None
        for begin in range(0, len(run.time), SAMPLES):
            lo, hi = max(0, begin - half), min(len(run.time), begin + SAMPLES + half)
            values = machine.evaluate.map([drive[:, lo:hi], states[:, lo:hi], p, delays], kept).T
            outputs.append(_keep(run, values, lo, begin, min(begin + SAMPLES, len(run.time))))
        merged = np.concatenate(outputs)
        whole = machine.evaluate.whole(merged)
        rows = whole.reshape(len(whole), whole.shape[1] // n, n)
        rows[:, :, run.braked] = 0.0
        if run.undriven.any():
            ratio, slopes = self._inertia.nominal_over(run.position.mean(axis=0), p)
            times = np.where(run.undriven, ratio, 1.0)
            change = np.where(run.undriven, slopes[:, self._derived].T, 0.0)
            rows[:, 1:] = times * rows[:, 1:] + change * rows[:, :1]
            rows[:, 0] *= times
        if run.without:
            gone = self.path.owned_by(run.without)
            rows[:, [1 + k for k, i in enumerate(self._derived) if i in gone]] = 0.0
        return rows[:, 0], rows[:, 1:].transpose(0, 2, 1)

    def stages(self, run: Conditioned, p: np.ndarray) -> dict[str, np.ndarray]:
        """Return the unfiltered residual and stage torques of one run, each (N, n), N m of command."""
        n, names = self.path.n, ("actuator", "rotor", "load", "friction")
        residual, stages = self.along_run(self._machine(run).cut.balance, run, p)
        out = {name: stages.full()[i * n : (i + 1) * n].T for i, name in enumerate(names)}
        return {"residual": residual.full().T, **out}

    def along_run(self, function: ca.Function, run: Conditioned, p: np.ndarray) -> Any:
        """Return a function of (drive, states, p, T0), as those of :class:`stribeck.model.cut.Cut`, along one run."""
        delays = delays_of(self.path, p)
        drive = self._drives.along(run, delays)
        (states,) = self._states([run], [drive], p, delays)
        return function(drive, states, self.path.without(run.without, p), delays)

    def states(self, run: Conditioned, p: np.ndarray) -> np.ndarray:
        """Return the states (N, nx) of the cut along one run.

        Those of ``path.state_names``; with contacts, then how fast each flexible joint's motor gains on its link,
        rad/s^2; with bristles, then how fast the recorded motion bends each, N m/s.
        """
        delays = delays_of(self.path, p)
        (states,) = self._states([run], [self._drives.along(run, delays)], p, delays)
        return states[: self._machine(run).cut.nx].T

    def _states(
        self, runs: Sequence[Conditioned], drives: Sequence[np.ndarray], p: np.ndarray, delays: np.ndarray
    ) -> list[np.ndarray]:
        """Return states and sensitivities (nx (1 + active), N) along each run."""
        if self.known and runs is self.runs and self.reuses:
            return [states.T for states in self.known]

        def states(run: Conditioned, drives: Sequence[np.ndarray], abreast: Abreast) -> list[np.ndarray]:
            return self._machine(run).states(drives, self.path.without(run.without, p), delays, abreast)

        return self._by_machine(runs, drives, states)

    def _states_at(
        self, drives: Sequence[np.ndarray], values: Sequence[np.ndarray], delays: np.ndarray
    ) -> list[list[np.ndarray]]:
        """Return states (nx, N) along each run at each of some parameter values, all of them side by side."""

        def states(run: Conditioned, drives: Sequence[np.ndarray], abreast: Abreast) -> list[list[np.ndarray]]:
            there = [self.path.without(run.without, p) for p in values]
            return self._machine(run).states_at(drives, there, delays, abreast)

        return self._by_machine(self.runs, drives, states)

    def _by_machine(
        self,
        runs: Sequence[Conditioned],
        drives: Sequence[np.ndarray],
        states: Callable[[Conditioned, Sequence[np.ndarray], Abreast], list[Found]],
    ) -> list[Found]:
        """Return what runs of one machine, and without the same effects, have side by side, run by run."""
        alike = [(self._machine(run), run.without) for run in runs]
        out: dict[int, Found] = {}
        for one in dict.fromkeys(alike):
            mine = [i for i, its in enumerate(alike) if its == one]
            found = states(runs[mine[0]], [drives[i] for i in mine], self._abreast.setdefault(one, Abreast()))
            out |= dict(zip(mine, found, strict=True))
        return [out[i] for i in range(len(runs))]

    @cached_property
    def reuses(self) -> bool:
        """Whether the states that are known are taken as they are."""
        return all(self._same_states(self._machine(run).cut) for run in self.runs)

    def _same_states(self, cut: Cut) -> bool:
        return self.known is not None and cut.nx == self.known[0].shape[1] and not cut.active


def _keep(run: Conditioned, values: np.ndarray, lo: int, begin: int, end: int) -> np.ndarray:
    """Return the filtered rows whose analysis sample lies in [begin, end), from values that start at lo."""
    wanted = run.analysis_index
    wanted = wanted[(wanted >= begin) & (wanted < end)]
    if len(wanted) == 0:
        return np.zeros((0, values.shape[1]))
    half = len(run.taps) // 2
    return run.filtered(values[wanted[0] - half - lo : wanted[-1] + half + 1 - lo])
