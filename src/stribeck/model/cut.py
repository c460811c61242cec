"""The path cut at the measured joint, compiled: recorded motion in, the torque that does not balance out.

States (a friction bristle, an actuator lag, a flexible joint's link) follow the same drive. Sensitivities by the
parameters are carried along with them.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from stribeck.model.advance import Advance
from stribeck.model.balance import Balance
from stribeck.model.drive import Drive
from stribeck.model.observer import observed
from stribeck.model.path import SignalPath
from stribeck.model.resting import begun, rested, resting
from stribeck.model.sensitivity import Sensitivity


class Cut:
    """Compiled cut of a signal path.

    Parameters
    ----------
    path : SignalPath
    sample_time : float
        Step of the uniform grid on which the states advance, s.
    columns : sequence of int or None
        Parameters whose derivatives are wanted; all where None.
    observe : bool
        Whether links and bristles at rest are corrected by the residual (:mod:`stribeck.model.observer`,
        :mod:`stribeck.model.resting`).

    Attributes
    ----------
    active : tuple of int
        Parameters on which the states depend (columns that the sensitivity recursion carries).
    """

    def __init__(
        self, path: SignalPath, sample_time: float, columns: Sequence[int] | None = None, *, observe: bool = True
    ) -> None:
        self.path, self.sample_time, self.n, self.observe = path, sample_time, path.n, observe
        self.columns = tuple(range(len(path.entries))) if columns is None else tuple(columns)
        self.drive = Drive.symbols(path.n)
        self._sample = Balance(path)
        self.nx = self._sample.x.numel()
        self._later = Advance(self._sample, sample_time)

    @cached_property
    def _advanced(self) -> tuple[Sensitivity, Drive, Sensitivity]:
        """States and their sensitivities by the wanted columns, the drive one sample later, and both by then.

        Each parameter's sensitivities depend on no other's: those of the active ones can be picked.
        """
        after = Drive.symbols(self.n, "1")
        carried = Sensitivity(self._sample.x, self.columns, ca.SX.sym("S", self.nx, len(self.columns)))
        moved = self._later(self.drive, after, carried)
        if self.observe:
            moved = observed(self._sample, self.sample_time, self.drive, carried, moved)
            moved = rested(self._sample, self.sample_time, self.drive, carried, moved)
        return carried, after, moved

    @cached_property
    def active(self) -> tuple[int, ...]:
        """Parameters on which the states depend."""
        if self.nx == 0:
            return ()
        sample, drive = self._sample, self.drive
        moves = [sample.derivatives(drive, sample.x), self._started]
        told = [*self.path.flexible, *resting(self.path)]
        if self.observe and told:
            moves.append(sample.residual(drive, sample.x, settled=False)[0][told])
        rows = ca.jacobian_sparsity(ca.vertcat(*moves), self.path.p)
        return tuple(sorted({int(c) for c in rows.get_triplet()[1]} & set(self.columns)))

    @cached_property
    def _started(self) -> Any:
        start = self._sample.start(self.drive)
        return begun(self._sample, self.drive, start) if self.observe else start

    @cached_property
    def begin(self) -> ca.Function:
        """(drive, p, T0) -> states and their sensitivities, stacked (nx (1 + active), 1)."""
        start = ca.vertcat(self._started, ca.SX.zeros(self.nx - self.path.x.numel()))
        sensitivity = ca.jacobian(start, self.path.p)[:, list(self.active)]
        return ca.Function(
            "begin",
            [self.drive.stacked, self.path.p, self._sample.delay_at],
            [ca.densify(ca.vertcat(start, ca.vec(sensitivity)))],
        )

    @cached_property
    def follow(self) -> ca.Function:
        """(states, drive now, drive one sample later, p, T0) -> states and sensitivities one sample later."""
        carried, after, moved = self._advanced
        active = [self.columns.index(i) for i in self.active]
        state, later = (ca.vertcat(s.states, ca.vec(s.columns[:, active])) for s in (carried, moved))
        inputs = [state, self.drive.stacked, after.stacked, self.path.p, self._sample.delay_at]
        return ca.Function("follow", inputs, [ca.densify(later)])

    def settled(self, states: np.ndarray) -> np.ndarray:
        """Return states and sensitivities (nx (1 + active), N) along a recording as the residual takes them.

        What a link loses against its motor in a blow is over in an instant, and so is what damps a bristle that bends
        at a reversal. The residual is sampled: it takes the mean from the sample before to the sample after, so that no
        momentum is missed.
        """
        sudden = self.nx - self.path.x.numel()
        if not sudden:
            return states
        out = np.array(states, order="C")
        rows = out.reshape(1 + len(self.active), self.nx, -1)[:, -sudden:]
        whole = rows.copy()  # numpy's gradient takes twice as long: a tenth of a residual with bristles
        np.subtract(whole[..., 2:], whole[..., :-2], out=rows[..., 1:-1])
        rows[..., 1:-1] *= 0.5
        for end, (one, other) in ((0, (1, 0)), (-1, (-1, -2))):
            rows[..., end] = whole[..., one] - whole[..., other]
        rows /= self.sample_time
        return out

    @cached_property
    def evaluate(self) -> ca.Function:
        """(drive, states, p, T0) -> residual (n, 1) and its Jacobian by the wanted columns, stacked."""
        carried = ca.SX.sym("S", self.nx, len(self.active))
        residual, _ = self._sample.residual(self.drive, self._sample.x)
        jacobian = ca.SX(ca.densify(ca.jacobian(residual, self.path.p)[:, list(self.columns)]))
        if self.nx:
            place = [self.columns.index(i) for i in self.active]
            jacobian[:, place] += ca.mtimes(ca.jacobian(residual, self._sample.x), carried)
        state = ca.vertcat(self._sample.x, ca.vec(carried))
        inputs = [self.drive.stacked, state, self.path.p, self._sample.delay_at]
        return ca.Function("evaluate", inputs, [ca.densify(ca.vertcat(residual, ca.vec(jacobian)))])

    @cached_property
    def balance(self) -> ca.Function:
        """(drive, states, p, T0) -> residual (n, 1) and the stages' torques stacked (4 n, 1)."""
        carried = ca.SX.sym("S", self.nx, len(self.active))
        residual, stages = self._sample.residual(self.drive, self._sample.x)
        state = ca.vertcat(self._sample.x, ca.vec(carried))
        inputs = [self.drive.stacked, state, self.path.p, self._sample.delay_at]
        return ca.Function("balance", inputs, [ca.densify(residual), ca.densify(ca.vertcat(*stages.values()))])
