"""What the laws of an arm file add to Tustin's friction along recordings, to be taken off what is read there."""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from stribeck.identify.conditioning import Conditioned
from stribeck.identify.residual import Residual
from stribeck.model.balance import Balance
from stribeck.model.drive import Drive
from stribeck.model.effect import FrictionEffect
from stribeck.model.path import SignalPath
from stribeck.model.tustin import tustin_level, tustin_viscous

Floats = NDArray[np.float64]

OTHER = 1.5  # times the constants, at which a law that is apart from them adds the same
SAME = 1e-6  # of the break-away torque, by which what it adds may change


class Beyond:
    """What effects add to the friction of each joint, forward and backward, N m at the joint.

    Parameters
    ----------
    residual : Residual
        Of the path, whose states and drives are used.
    """

    def __init__(self, residual: Residual) -> None:
        self.path, self.residual = residual.path, residual
        laws = any(isinstance(place.effect, FrictionEffect) for place in self.path.placed)
        self._added = _function(self.path) if laws else None

    def __call__(self, run: Conditioned, p: Floats) -> Floats:
        """Return it along one run (N, n, 2) at parameter values (p,)."""
        n = self.path.n
        if self._added is None:
            return np.zeros((len(run.time), n, 2))
        return np.asarray(self.residual.along_run(self._added, run, p)).T.reshape(-1, 2, n).transpose(0, 2, 1)

    def apart(self, p: Floats, runs: Sequence[Conditioned]) -> tuple[bool, ...]:
        """Return whether what is added at each joint is the same whatever Tustin's constants are.

        Where it is not (a law that multiplies, or with a past of its own) readings cannot be rid of it.
        """
        entries = self.path.entries
        other = p * np.where([entry.owner == "friction" for entry in entries], OTHER, 1.0)
        change = np.max([np.abs(self(run, other) - self(run, p)).max(axis=(0, 2)) for run in runs], axis=0)
        dry = [(e.joint, p[i]) for i, e in enumerate(entries) if e.owner == "friction" and e.name in ("C0", "C1")]
        size = [sum(value for joint, value in dry if joint == j) for j in range(self.path.n)]
        return tuple(bool(one <= SAME * whole) for one, whole in zip(change, size, strict=True))


def _function(path: SignalPath) -> ca.Function:
    """(drive, states, p, T0) -> what is added at each joint forward, then backward, (2 n, 1)."""
    sample, drive = Balance(path), Drive.symbols(path.n)
    signals, _ = sample.signals(drive, sample.x)
    added = []
    for way in (1.0, -1.0):
        for j, s in enumerate(signals):
            own, other = path.constants(j, way), path.constants(j, -way)
            speed = ca.fabs(s.velocity)
            level = path.level(j, speed, way, s, sample.x) - tustin_level(speed, own)
            ahead, back = (own, other) if way > 0.0 else (other, own)
            viscous = path.viscous(j, s, sample.x) - tustin_viscous(s.velocity, ahead["C2"], back["C2"])
            added.append(way * level + viscous)
    inputs = [drive.stacked, sample.x, path.p, sample.delay_at]
    return ca.Function("beyond", inputs, [ca.densify(ca.vertcat(*added))])
