"""Motions that an engineer would record: one curve a joint, each starting and ending at rest."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
Curve: TypeAlias = Callable[[Array], tuple[Array, Array, Array]]


@dataclass(frozen=True)
class Motion:
    """A motion to record.

    Attributes
    ----------
    name : str
        Says what it is.
    duration : float
        s.
    curves : tuple of callables, one a joint
        Times (N,), s, to position, velocity and acceleration (N,), rad, rad/s, rad/s^2.
    torque : tuple of callables or None
        Times (N,), s, to a torque (N,) added to the command, N m.
    held : tuple of int
        Joints that a brake holds and no command drives.
    """

    name: str
    duration: float
    curves: tuple[Curve, ...]
    torque: tuple[Callable[[Array], Array], ...] | None = None
    held: tuple[int, ...] = ()

    def sample(self, t: Array) -> tuple[Array, Array, Array]:
        """Return position, velocity and acceleration (N, n) at the times `t`, s; held outside them."""
        inside = np.clip(t, 0.0, self.duration)
        moving = ((t >= 0.0) & (t <= self.duration)).astype(np.float64)[:, None]
        columns = [curve(inside) for curve in self.curves]
        q, dq, ddq = (np.stack([c[i] for c in columns], axis=1) for i in range(3))
        return q, dq * moving, ddq * moving


def from_velocity(times: Sequence[float] | Array, velocity: Sequence[float] | Array, start: float = 0.0) -> Curve:
    """Return the curve from `start`, rad, whose velocity is linear between knots (`times`, s; `velocity`, rad/s)."""
    knots, speed = np.asarray(times, dtype=np.float64), np.asarray(velocity, dtype=np.float64)
    slope = np.diff(speed) / np.diff(knots)
    place = start + np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(knots))])

    def curve(t: Array) -> tuple[Array, Array, Array]:
        i = np.clip(np.searchsorted(knots, t, side="right") - 1, 0, len(slope) - 1)
        s = np.clip(t, knots[0], knots[-1]) - knots[i]
        return place[i] + speed[i] * s + 0.5 * slope[i] * s**2, speed[i] + slope[i] * s, slope[i] + 0.0 * s

    return curve


def hold(angle: float) -> Curve:
    """Return the curve that stays at `angle`, rad."""
    return lambda t: (np.full_like(t, angle), np.zeros_like(t), np.zeros_like(t))


def multisine(
    amplitude: Array, frequency: Array, phase: Array, centre: float, duration: float, fade: float = 1.0
) -> Curve:
    """Return a sum of sines around a centre that grows at the start and fades at the end.

    Parameters
    ----------
    amplitude, frequency, phase : array (K,)
        Of each sine, rad, Hz, rad.
    centre : float
        rad.
    duration, fade : float
        Of the whole, and of growing and fading, s.
    """

    def curve(t: Array) -> tuple[Array, Array, Array]:
        w, dw, ddw = _fade(t, duration, fade)
        omega = 2.0 * np.pi * frequency
        angle = np.outer(t, omega) + phase
        s = np.sin(angle) @ amplitude
        ds, dds = np.cos(angle) @ (amplitude * omega), -np.sin(angle) @ (amplitude * omega**2)
        return centre + w * s, dw * s + w * ds, ddw * s + 2.0 * dw * ds + w * dds

    return curve


def sweep(amplitude: float, low: float, high: float, centre: float, duration: float, fade: float = 1.0) -> Curve:
    """Return a sine whose frequency rises from low to high while its peak speed stays.

    Parameters
    ----------
    amplitude : float
        At the lowest frequency, rad.
    low, high : float
        Frequencies, Hz.
    centre : float
        rad.
    duration, fade : float
        Of the whole, and of growing and fading, s.
    """
    rate = np.log(high / low) / duration

    def curve(t: Array) -> tuple[Array, Array, Array]:
        w, dw, ddw = _fade(t, duration, fade)
        growth = np.exp(rate * t)
        angle, omega = 2.0 * np.pi * low * (growth - 1.0) / rate, 2.0 * np.pi * low * growth
        a = amplitude / growth
        s, ds = a * np.sin(angle), a * (omega * np.cos(angle) - rate * np.sin(angle))
        dds = a * ((rate**2 - omega**2) * np.sin(angle) - rate * omega * np.cos(angle))
        return centre + w * s, dw * s + w * ds, ddw * s + 2.0 * dw * ds + w * dds

    return curve


def point_to_point(points: Sequence[float], moves: Sequence[float], rests: Sequence[float]) -> Curve:
    """Return quintic moves between `points`, rad, that take `moves`, s, each followed by a rest of `rests`, s."""
    starts = np.concatenate([[0.0], np.cumsum(np.add(moves, rests))])

    def curve(t: Array) -> tuple[Array, Array, Array]:
        i = np.clip(np.searchsorted(starts, t, side="right") - 1, 0, len(moves) - 1)
        length, step = np.asarray(moves)[i], np.diff(points)[i]
        u = np.clip((t - starts[i]) / length, 0.0, 1.0)
        q = np.asarray(points)[i] + step * u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
        return q, step / length * 30.0 * (u * (1.0 - u)) ** 2, step / length**2 * 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u)

    return curve


def _fade(t: Array, duration: float, fade: float) -> tuple[Array, Array, Array]:
    """Window from 0 to 1 to 0 with two continuous derivatives, and these derivatives."""
    up, down = np.clip(t / fade, 0.0, 1.0), np.clip((duration - t) / fade, 0.0, 1.0)
    w1, d1, e1 = _smooth(up)
    w2, d2, e2 = _smooth(down)
    w, dw = w1 * w2, (d1 * w2 - w1 * d2) / fade
    return w, dw, (e1 * w2 - 2.0 * d1 * d2 + w1 * e2) / fade**2


def _smooth(u: Array) -> tuple[Array, Array, Array]:
    return (
        u**3 * (10.0 - 15.0 * u + 6.0 * u**2),
        30.0 * (u * (1.0 - u)) ** 2,
        60.0 * u * (1.0 - u) * (1.0 - 2.0 * u),
    )
