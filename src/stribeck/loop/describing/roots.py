"""Harmonic balance with one harmonic: every amplitude and frequency at which the loop sustains a sinusoid."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stribeck.arm.values import Friction
from stribeck.loop.describing.frequency import LinearPart
from stribeck.loop.describing.residual import Compensator
from stribeck.loop.describing.tustin import describing_function

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

SLOWEST, FASTEST = 1e-3, 1e2  # of the frequencies that are searched, relative to sqrt(Kp/J)
SPEEDS, FREQUENCIES = 160, 320  # of the grid, before it is refined
TURN, SPLITS, MOST_FREQUENCIES = 0.25, 6, 1280  # W may change by so much of itself from one frequency to the next
TABLE = 3000
CLOSE = 1e-9  # of |1 + W N| at a root
ITERATIONS, HALVINGS = 40, 6  # of Newton's method, and of one step of it that does not help
FARTHEST = 0.5  # that a root lies from its cell, in the logarithms of amplitude and frequency


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

    Parameters
    ----------
    part : LinearPart
    friction : Friction
        Symmetric constants.
    compensator : Compensator
    speed : array
        Amplitude V of the velocity, rad/s.
    omega : array
        rad/s.
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
    omega = _split(part, np.geomspace(SLOWEST * part.own_frequency, top, FREQUENCIES))
    speed = _speeds(part, friction, compensator)
    rows, columns = _cells(_survey(part, friction, compensator, speed, omega))
    found: list[Root] = []
    begin = _starts(np.log(speed), np.log(omega), rows, columns, kinks=compensator.dead_band > 0.0)
    for solved in _refined(part, friction, compensator, begin):
        if solved.omega < part.highest and not any(_same(solved, other) for other in found):
            found.append(solved)
    return tuple(sorted(found, key=lambda r: r.omega))


def _split(part: LinearPart, omega: Floats) -> Floats:
    """Return frequencies with more between them where W turns fast, as at a resonance that is hardly damped."""
    for _ in range(SPLITS):
        w = part.response(omega)
        fast = np.abs(np.diff(w)) > TURN * np.minimum(np.abs(w[1:]), np.abs(w[:-1]))
        if not fast.any() or len(omega) + fast.sum() > MOST_FREQUENCIES:
            break
        omega = np.sort(np.append(omega, np.sqrt(omega[1:] * omega[:-1])[fast]))
    return omega


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


def _starts(
    speed: Floats, omega: Floats, rows: NDArray[np.intp], columns: NDArray[np.intp], kinks: bool
) -> Floats:  # fmt: skip
    """Return the centres of cells; where the balance may have a kink inside, places near the corners as well."""
    shares = ((0.5, 0.5), (0.1, 0.1), (0.9, 0.1), (0.1, 0.9), (0.9, 0.9)) if kinks else ((0.5, 0.5),)
    size = np.stack([speed[rows + 1] - speed[rows], omega[columns + 1] - omega[columns]], axis=1)
    corner = np.stack([speed[rows], omega[columns]], axis=1)
    return np.concatenate([corner + np.array(share) * size for share in shares])


def _refined(part: LinearPart, friction: Friction, compensator: Compensator, begin: Floats) -> list[Root]:
    """Return the roots to which Newton's method leads from places (K, 2), logarithms of amplitude and frequency.

    All places at once: a loop with a long delay has hundreds of them.
    """

    def miss(x: Floats) -> Floats:
        value = balance(part, friction, compensator, np.exp(x[:, 0]), np.exp(x[:, 1]))
        return np.stack([value.real, value.imag], axis=1)

    x, going = begin.copy(), np.ones(len(begin), dtype=bool)
    for _ in range(ITERATIONS):
        if not going.any():
            break
        x[going], moved = _stepped(miss, x[going], begin[going])
        going[going] = moved
    at = (np.abs(miss(x)).max(axis=1) <= CLOSE) if len(x) else going
    x = x[at & (np.abs(x - begin).max(axis=1, initial=0.0) <= FARTHEST)]  # beyond is another cell's
    slopes = _slopes(miss, x)
    stable = slopes[:, 0, 0] * slopes[:, 1, 1] - slopes[:, 0, 1] * slopes[:, 1, 0] > 0.0
    return [Root(float(v), float(w), bool(calm)) for (v, w), calm in zip(np.exp(x), stable, strict=True)]


def _stepped(miss: Callable[[Floats], Floats], x: Floats, begin: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Return places after one step of Newton's method, shortened till it helps, and which of them still move."""
    value, slopes = miss(x), _slopes(miss, x)
    singular = np.abs(np.linalg.det(slopes)) < 1e-12 * np.abs(slopes).max(axis=(1, 2)) ** 2 + 1e-300
    slopes[singular] = np.eye(2)  # no step from there
    move = np.where(singular[:, None], 0.0, -np.linalg.solve(slopes, value[..., None])[..., 0])
    move *= np.minimum(1.0, 0.3 / np.maximum(np.abs(move).max(axis=1), 1e-300))[:, None]
    size, share, best = np.abs(value).max(axis=1), np.ones(len(x)), x
    helps = np.zeros(len(x), dtype=bool)
    for _ in range(HALVINGS):
        tried = np.where(helps[:, None], best, x + share[:, None] * move)
        better = np.abs(miss(tried)).max(axis=1) < size
        best = np.where((better | helps)[:, None], tried, best)
        helps |= better
        if helps.all():
            break
        share = np.where(helps, share, 0.5 * share)
    inside = np.abs(best - begin).max(axis=1) <= 2.0 * FARTHEST
    return best, helps & inside & (size > 1e-14)


def _slopes(miss: Callable[[Floats], Floats], x: Floats) -> Floats:
    """Return the derivatives (K, 2, 2) of the balance's parts (rows) by both logarithms (columns)."""
    step = 1e-5
    return np.stack([(miss(x + move) - miss(x - move)) / (2.0 * step) for move in step * np.eye(2)], axis=2)


def _same(one: Root, other: Root) -> bool:
    return abs(one.omega / other.omega - 1.0) < 1e-5 and abs(one.velocity / other.velocity - 1.0) < 1e-5
