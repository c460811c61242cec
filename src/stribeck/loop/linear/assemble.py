"""Plant and controllers together: the closed loop, and the loop broken at one joint's command."""

from __future__ import annotations

import math
from dataclasses import dataclass

import control as ct
import numpy as np
from numpy.typing import NDArray

from stribeck.arm import Arm
from stribeck.errors import InputError
from stribeck.loop.linear.controller import Controller, controller, derivative_gain, tuned_inertia
from stribeck.loop.linear.operating import OperatingPoint
from stribeck.loop.linear.plant import linearise
from stribeck.loop.linear.sampled import lagged, sampled
from stribeck.simulate.loop import JointLoop, Loop

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Broken:
    """A loop broken at a joint's command: the transfer L, whose whole samples of delay need no states.

    Attributes
    ----------
    system : control.StateSpace
        L without them.
    late : int
        Samples.
    """

    system: ct.StateSpace
    late: int


@dataclass(frozen=True)
class Assembly:
    """The linear loop of an arm about one operating point; the plant is worked out once, gains are then cheap.

    Attributes
    ----------
    plant : control.StateSpace
        From the commands of the m moving joints to their positions, then velocities; sampled where the loop is, with
        hold, actuator lags and all delays.
    entries : tuple of m JointLoop
        Their controllers.
    inertia : array (m,)
        That each joint moves at this point, the others held, kg m^2.
    tuned : array (m,)
        The same where the loop starts, by which its controllers set critical damping.
    slope : array (m,)
        Slope of the velocity feedback that a compensation adds at this point, N m s/rad.
    sample_time : float
        s; 0 is continuous.
    prompt : tuple of m (control.StateSpace, int)
        For each joint, the plant without the whole samples by which that joint's command is late, and their number.
    """

    plant: ct.StateSpace
    entries: tuple[JointLoop, ...]
    inertia: Floats
    tuned: Floats
    slope: Floats
    sample_time: float
    prompt: tuple[tuple[ct.StateSpace, int], ...]

    def index(self, joint: str) -> int:
        """Return the place of a joint by its name; raise `InputError` where it does not move."""
        names = [entry.joint for entry in self.entries]
        if joint not in names:
            raise InputError("the joint does not move at this operating point", joint, f"use one of: {names}")
        return names.index(joint)

    def broken(self, joint: str, kp: float | None = None) -> Broken:
        """Return the loop transfer L at a joint's command, every other loop closed; ``kp`` replaces its own gain."""
        i = self.index(joint)
        closed = [k != i for k in range(len(self.entries))]
        plant, late = self.prompt[i]
        a, b, c, d = self._closed(plant, closed, i, kp)
        return Broken(ct.ss(a, b[:, [i]], -c[[i]], -d[[i]][:, [i]], self.sample_time), late)

    def poles(self, joint: str | None = None, kp: float | None = None) -> NDArray[np.complex128]:
        """Return the poles of the closed loop, in 1/s for a continuous one; ``kp`` replaces a joint's own gain."""
        i = -1 if joint is None else self.index(joint)
        a, _, _, _ = self._closed(self.plant, [True] * len(self.entries), i, kp)
        return np.asarray(np.linalg.eigvals(a), dtype=complex)

    def is_stable(self, joint: str | None = None, kp: float | None = None) -> bool:
        """Tell whether every pole of the closed loop decays."""
        poles = self.poles(joint, kp)
        return bool(np.all(np.abs(poles) < 1.0) if self.sample_time > 0.0 else np.all(poles.real < 0.0))

    def _closed(
        self, plant: ct.StateSpace, closed: list[bool], changed: int, kp: float | None
    ) -> tuple[Floats, Floats, Floats, Floats]:
        """Return the system from commands to the controllers' commands, some of the loops closed."""
        parts = [self._controller(i, kp if i == changed else None) for i in range(len(self.entries))]
        ap, bp, cp = (np.asarray(part) for part in (plant.A, plant.B, plant.C))
        ac, bc, cc, dc = _stack(parts)
        through = bp @ np.diag(np.array(closed, dtype=float))
        a = np.block([[ap + through @ dc @ cp, through @ cc], [bc @ cp, ac]])
        b = np.vstack([bp, np.zeros((len(ac), bp.shape[1]))])
        return a, b, np.hstack([dc @ cp, cc]), np.zeros((len(parts), bp.shape[1]))

    def _controller(self, i: int, kp: float | None) -> Controller:
        entry = self.entries[i]
        gain = entry.kp if kp is None else kp
        kv = derivative_gain(entry, gain, float(self.tuned[i])) - float(self.slope[i])
        return controller(entry, gain, kv, self.sample_time)


def assemble(arm: Arm, loop: Loop, point: OperatingPoint) -> Assembly:
    """Return the linear loop about an operating point.

    Parameters
    ----------
    arm : Arm
    loop : Loop
        Checked (`stribeck.simulate.check_loop`). The slope of a compensation on measured velocity counts where its
        joint slides; elsewhere a compensation has none.
    point : OperatingPoint

    Raises
    ------
    StribeckError
        When no command keeps the arm steady there.
    """
    found = linearise(arm, point)
    by_name = {entry.joint: entry for entry in loop.joints}
    entries = tuple(by_name[arm.names[j]] for j in found.joints)
    plant = lagged(found.system, np.array([entry.actuator_lag for entry in entries]))
    plant, prompt = _sampled(plant, loop.sample_time, entries, found.delays)
    slope = np.array([_slope(arm, entry, point) for entry in entries])
    tuned = tuned_inertia(arm, loop)[list(found.joints)]
    return Assembly(plant, entries, found.inertia, tuned, slope, loop.sample_time, prompt)


def _sampled(
    plant: ct.StateSpace, sample_time: float, entries: tuple[JointLoop, ...], own: Floats
) -> tuple[ct.StateSpace, tuple[tuple[ct.StateSpace, int], ...]]:
    """Return the plant as the loop samples it, with all delays; and for each joint that without its whole samples."""
    if sample_time == 0.0:
        return plant, ((plant, 0),) * len(entries)
    delays = own + np.array([entry.delay_samples * sample_time for entry in entries])
    late = [math.floor(delay / sample_time + 1e-9) for delay in delays]
    less = sample_time * np.diag(late)
    prompt = tuple(
        (sampled(plant, sample_time, np.maximum(delays - less[i], 0.0)), count) for i, count in enumerate(late)
    )
    return sampled(plant, sample_time, delays), prompt


def _slope(arm: Arm, entry: JointLoop, point: OperatingPoint) -> float:
    """Return d(compensation)/d(velocity), N m s/rad."""
    j = arm.names.index(entry.joint)
    c, speed = entry.compensation, abs(point.velocity[j])
    if c.kind != "feedback" or point.contact[j] != "slides" or speed <= c.dead_band:
        return 0.0
    f = arm.joints[j].friction if point.velocity[j] > 0.0 else arm.joints[j].backward
    return float(c.ratio * (f.C2 - f.C1 / f.alpha * np.exp(-speed / f.alpha)))


def _stack(parts: list[Controller]) -> tuple[Floats, Floats, Floats, Floats]:
    """Return all controllers as one, its input all positions, then all velocities."""
    m, size = len(parts), sum(len(part.a) for part in parts)
    a, b, c, d = np.zeros((size, size)), np.zeros((size, 2 * m)), np.zeros((m, size)), np.zeros((m, 2 * m))
    first = 0
    for i, part in enumerate(parts):
        rows = slice(first, first + len(part.a))
        a[rows, rows], b[rows, i], b[rows, m + i] = part.a, part.b[:, 0], part.b[:, 1]
        c[i, rows], d[i, i], d[i, m + i] = part.c[0], part.d[0, 0], part.d[0, 1]
        first += len(part.a)
    return a, b, c, d
