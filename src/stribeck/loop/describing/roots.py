"""Harmonic balance with one harmonic: every amplitude and frequency at which the loop sustains a sinusoid."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import root

from stribeck.arm.values import Friction
from stribeck.loop.describing.frequency import LinearPart
from stribeck.loop.describing.residual import Compensator
from stribeck.loop.describing.tustin import describing_function

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

SLOWEST, FASTEST = 1e-3, 1e2  # of the frequencies that are searched, relative to sqrt(Kp/J)
SPEEDS, FREQUENCIES = 160, 320  # of the grid
TABLE = 3000
CLOSE = 1e-9  # of |1 + W N| at a root


@dataclass(frozen=True)
class Root:
    """A sinusoid that the loop sustains.

    Attributes
    ----------
    velocity : float
        Its amplitude, rad/s.
    omega : float
        rad/s; below the Nyquist frequency.
    stable : bool
        Whether a little larger one shrinks and a smaller one grows (Loeb's criterion).
    """

    velocity: float
    omega: float
    stable: bool

    @property
    def amplitude(self) -> float:
        """Of the position, rad."""
        return float(self.velocity / self.omega)

    @property
    def period(self) -> float:
        """In s."""
        return 2.0 * math.pi / self.omega


def balance(part: LinearPart, friction: Friction, compensator: Compensator, speed: Floats, omega: Floats) -> Complex:
    """Return 1 + W(omega) [N(V) - A(omega) E(omega) Nc(|E| V)], zero where a sinusoid sustains itself.

    A is the way of the command to the motor and E the velocity estimator. `speed` and `omega` broadcast.
    """
    w = np.asarray(omega, dtype=float)
    net = describing_function(np.asarray(speed, dtype=float), friction)
    return np.asarray(1.0 + part.response(w) * (net - compensation(part, compensator, speed, w)))


def compensation(part: LinearPart, compensator: Compensator, speed: Floats, omega: Floats) -> Complex:
    """Return the motor torque of the compensation over the true velocity, N m s/rad."""
    if compensator.ratio == 0.0:
        return np.zeros(np.broadcast(speed, omega).shape, dtype=complex)
    e = part.estimator(omega)
    return np.asarray(
        part.passage(omega) * e * compensator.describing_function(np.abs(e) * speed, _lead(part, compensator, omega, e))
    )


def _lead(part: LinearPart, compensator: Compensator, omega: Floats, e: Complex) -> Floats:
    """Return by how much the sign that holds in the dead-band leads the estimate's cosine, rad."""
    lead = -np.angle(e)  # the error is a quarter period ahead of the velocity
    if compensator.at_zero != "set_valued" or compensator.dead_band == 0.0:
        return np.asarray(lead)
    s = 1j * omega
    torque = -part.feedback(omega) / part.passage(omega)  # per velocity; per error it is -s times that
    return np.asarray(lead + np.angle(-s * torque))


def find_roots(part: LinearPart, friction: Friction, compensator: Compensator) -> tuple[Root, ...]:
    """Return every sustained sinusoid below the Nyquist frequency, slowest first.

    Cells of a grid over amplitude and frequency in which both parts of the balance change sign start Newton's method.

    Parameters
    ----------
    part : LinearPart
    friction : Friction
        Symmetric constants.
    compensator : Compensator
    """
    top = min(FASTEST * part.own_frequency, (1.0 - 1e-6) * part.highest)
    omega = np.geomspace(SLOWEST * part.own_frequency, top, FREQUENCIES)
    speed = _speeds(part, friction, compensator)
    found: list[Root] = []
    for i, k in zip(*_cells(_survey(part, friction, compensator, speed, omega)), strict=True):
        start = np.array([math.log(speed[i] * speed[i + 1]), math.log(omega[k] * omega[k + 1])]) / 2.0
        solved = _refine(part, friction, compensator, start)
        if solved is not None and solved.omega < part.highest and not any(_same(solved, other) for other in found):
            found.append(solved)
    return tuple(sorted(found, key=lambda r: r.omega))


def _survey(part: LinearPart, friction: Friction, compensator: Compensator, speed: Floats, omega: Floats) -> Complex:
    """Return the balance on a grid (V, F); without a dead-band the compensation is read from a table, to 1e-5."""
    if compensator.dead_band > 0.0 or compensator.ratio == 0.0:
        return balance(part, friction, compensator, speed[:, None], omega)
    seen = part.estimator(omega)
    size = np.abs(seen) * speed[:, None]
    table = np.geomspace(size.min(), size.max(), TABLE)
    answer = compensator.ratio * np.interp(np.log(size), np.log(table), describing_function(table, friction))
    net = describing_function(speed, friction)[:, None] - part.passage(omega) * seen * answer
    return np.asarray(1.0 + part.response(omega) * net)


def _speeds(part: LinearPart, friction: Friction, compensator: Compensator) -> Floats:
    """Return amplitudes that span all sizes at which friction weighs in the balance, rad/s."""
    level = abs(friction.C0) + abs(friction.C1) + abs(friction.C2) * friction.alpha
    scale = max(level, 1e-9) / max(part.kv + friction.C2, 0.1 * part.inertia * part.own_frequency)
    low = min(1e-4 * scale, *(v for v in (0.01 * friction.alpha, 0.5 * compensator.dead_band) if v > 0.0))
    return np.geomspace(low, 1e4 * scale, SPEEDS)


def _cells(value: Complex) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the cells (lower corner) in which real and imaginary part both change sign."""
    found = np.ones((value.shape[0] - 1, value.shape[1] - 1), dtype=bool)
    for part in (value.real, value.imag):
        corners = np.stack([part[:-1, :-1], part[1:, :-1], part[:-1, 1:], part[1:, 1:]])
        found &= (corners.min(axis=0) <= 0.0) & (corners.max(axis=0) >= 0.0)
    rows, columns = np.nonzero(found)
    return rows, columns


def _refine(part: LinearPart, friction: Friction, compensator: Compensator, start: Floats) -> Root | None:
    def parts(x: Floats) -> Floats:
        x = np.clip(x, start - 1.0, start + 1.0)  # Newton's first steps may lead anywhere
        value = balance(part, friction, compensator, np.exp(x[[0]]), np.exp(x[[1]]))[0]
        return np.array([value.real, value.imag])

    solved = root(parts, start, tol=1e-13)
    if not np.all(np.isfinite(solved.x)) or np.abs(parts(solved.x)).max() > CLOSE:
        return None
    if np.abs(solved.x - start).max() > 0.5:  # another cell's
        return None
    step = 1e-5
    by_speed, by_omega = ((parts(solved.x + move) - parts(solved.x - move)) / (2.0 * step) for move in step * np.eye(2))
    stable = by_speed[0] * by_omega[1] - by_omega[0] * by_speed[1] > 0.0
    return Root(float(np.exp(solved.x[0])), float(np.exp(solved.x[1])), bool(stable))


def _same(one: Root, other: Root) -> bool:
    return abs(one.omega / other.omega - 1.0) < 1e-5 and abs(one.velocity / other.velocity - 1.0) < 1e-5
