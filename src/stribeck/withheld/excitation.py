"""The motions that a sensible engineer records on an unknown arm, within its torque."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from stribeck.arm import Arm
from stribeck.withheld.motions import Array, Curve, Motion, from_velocity, hold, multisine, point_to_point, sweep
from stribeck.withheld.plant import rigid_torque

SHARE = 0.7  # of the torque limit, at most, for the motion asked for


@dataclass(frozen=True)
class Reach:
    """What one joint may do: `centre` and `travel` to either side, rad; `speed`, rad/s; `acceleration`, rad/s^2."""

    centre: float
    travel: float
    speed: float
    acceleration: float


Maker = Callable[[np.random.Generator, Reach, float, float], Curve]


def reaches(arm: Arm, rng: np.random.Generator, travel: float = 1.2) -> tuple[Reach, ...]:
    """Return what each joint of `arm` may do with a third of its torque, around a random pose."""
    zero, unit = np.zeros((arm.n, arm.n)), np.eye(arm.n)
    inertia = np.diag(rigid_torque(arm, zero, zero, unit) - rigid_torque(arm, zero, zero, zero))
    result = []
    for joint, j in zip(arm.joints, inertia, strict=True):
        f = joint.friction
        torque = joint.torque_limit or 20.0 * (f.C0 + f.C1) + 10.0 * j
        speed = min(4.0, 0.3 * torque / f.C2 if f.C2 > 0.0 else 4.0)
        centre = rng.uniform(-0.8, 0.8)
        result.append(Reach(centre, travel * rng.uniform(0.7, 1.1), speed, min(60.0, 0.33 * torque / j)))
    return tuple(result)


def rich(rng: np.random.Generator, r: Reach, duration: float, size: float) -> Curve:
    """Fourier series of random phases up to about 3 Hz."""
    base = 1.0 / duration
    frequency = base * np.sort(rng.choice(np.arange(1, max(12, round(3.0 / base))), 8, replace=False))
    phase = rng.uniform(0.0, 2.0 * np.pi, 8)
    unit = multisine(rng.uniform(0.5, 1.0, 8) / frequency, frequency, phase, 0.0, duration)
    return _scaled(unit, r, duration, size)


def rising(rng: np.random.Generator, r: Reach, duration: float, size: float) -> Curve:
    """Sine whose frequency rises."""
    low = rng.uniform(0.2, 0.4)
    return _scaled(sweep(1.0, low, low * rng.uniform(12.0, 20.0), 0.0, duration), r, duration, size)


def reversals(rng: np.random.Generator, r: Reach, duration: float, size: float) -> Curve:
    """Slow ramps forth and back at speeds from below the Stribeck velocity upwards."""
    speeds = size * r.speed * np.geomspace(0.008, 0.25, 5) * rng.uniform(0.7, 1.4, 5)
    rng.shuffle(speeds)
    return _levels(np.stack([speeds, -speeds], axis=1).ravel(), duration, min(0.3, 0.3 * duration / 10), r.centre)


def stairs(rng: np.random.Generator, r: Reach, duration: float, size: float) -> Curve:
    """Stretches of constant speed, forth at rising and back at falling speed."""
    speeds = size * r.speed * np.linspace(0.05, 0.6, 5) * rng.uniform(0.8, 1.2)
    speeds *= min(1.0, 2.0 * r.travel / (speeds.sum() * duration / 10))
    return _levels(np.concatenate([speeds, -speeds[::-1]]), duration, 0.04 * duration, r.centre - r.travel)


def _levels(speeds: Array, duration: float, ramp: float, start: float) -> Curve:
    """Hold each of `speeds`, rad/s, for an equal time, with ramps of `ramp`, s, in between and at both ends."""
    edges = np.linspace(0.0, duration, len(speeds) + 1)
    times, velocity = [0.0], [0.0]
    for a, b, v in zip(edges[:-1], edges[1:], speeds, strict=True):
        times += [a + ramp, b]
        velocity += [v, v]
    times[-1] -= ramp
    return from_velocity([*times, duration], [*velocity, 0.0], start)


def moves(rng: np.random.Generator, r: Reach, duration: float, size: float) -> Curve:
    """Quick moves from point to point with pauses."""
    count = int(rng.integers(4, 7))
    share = rng.uniform(0.5, 1.0, 2 * count)
    share[:count] *= 1.3
    times = duration * share / share.sum()
    points = [r.centre]
    for length in times[:count]:
        longest = size * min(1.4 * r.travel, r.speed * length / 1.9, r.acceleration * length**2 / 5.8)
        away = (
            rng.choice([-1.0, 1.0]) if abs(points[-1] - r.centre) < 0.3 * r.travel else np.sign(r.centre - points[-1])
        )
        points.append(points[-1] + away * longest * rng.uniform(0.6, 1.0))
    return point_to_point(points, tuple(times[:count]), tuple(times[count:]))


def wander(rng: np.random.Generator, r: Reach, duration: float, size: float) -> Curve:
    """Pass random via-points without stopping, at changing pace."""
    count = int(duration / 0.7)
    gaps = rng.uniform(0.5, 1.0, count)
    times = np.concatenate([[0.0], np.cumsum(gaps)])
    velocity = np.concatenate([[0.0], rng.normal(0.0, 1.0, count - 1), [0.0]])
    velocity[1::2] = np.abs(velocity[1::2])
    velocity[2::2] = -np.abs(velocity[2::2])
    return _scaled(from_velocity(times * duration / times[-1], velocity), r, duration, size)


def creep(rng: np.random.Generator, r: Reach, duration: float, size: float) -> Curve:
    """Make steps of some milliradians up and down with holds: mostly stiction and what gives way before it."""
    count = 12
    up = size * 0.015 * rng.uniform(0.5, 2.5, count) * np.where(np.arange(count) % 6 < 3, 1.0, -1.0)
    points = r.centre + np.concatenate([[0.0], np.cumsum(up)])
    return point_to_point(tuple(points), (0.4 * duration / count,) * count, (0.6 * duration / count,) * count)


KINDS: dict[str, Maker] = {
    "slow reversals": reversals,
    "multisine": rich,
    "point to point": moves,
    "speed stairs": stairs,
    "via points": wander,
    "sweep": rising,
    "micro steps": creep,
}


def programme(
    arm: Arm, rng: np.random.Generator, kinds: Sequence[str], duration: float = 9.0, one_by_one: bool = False
) -> tuple[Motion, ...]:
    """Return one motion a kind, scaled so that the arm needs at most 70 % of its torque.

    Parameters
    ----------
    arm : Arm
        What the laboratory believes of its arm.
    rng : numpy.random.Generator
        Source of everything random.
    kinds : sequence of str
        Of `KINDS`.
    duration : float
        Of each motion, s.
    one_by_one : bool
        Whether only one joint moves at a time, in turn.
    """
    motions = []
    for i, kind in enumerate(kinds):
        around = reaches(arm, rng)
        moving = [not one_by_one or k == i % arm.n for k in range(arm.n)]
        seeds = [int(s) for s in rng.integers(2**63, size=arm.n)]
        motions.append(_within(arm, partial(_motion, kind, duration, around, moving, seeds)))
    return tuple(motions)


def _motion(
    kind: str, duration: float, around: Sequence[Reach], moving: Sequence[bool], seeds: Sequence[int], size: float
) -> Motion:
    curves = [
        KINDS[kind](np.random.default_rng(s), r, duration, size) if go else hold(r.centre)
        for r, go, s in zip(around, moving, seeds, strict=True)
    ]
    return Motion(kind, duration, tuple(curves))


def needed_torque(arm: Arm, q: Array, dq: Array, ddq: Array) -> Array:
    """Return the torque (N, n) that the arm with its sliding friction needs, N m; friction is zero at rest."""
    return rigid_torque(arm, q, dq, ddq) + sliding(arm, dq)


def sliding(arm: Arm, dq: Array) -> Array:
    """Return the friction (N, n) of sliding joints at the velocities `dq`, rad/s, N m; zero at rest."""
    torque = np.zeros_like(dq)
    for k, joint in enumerate(arm.joints):
        v = dq[:, k]
        for side, f in ((1.0, joint.friction), (-1.0, joint.backward)):
            level = f.C0 + f.C1 * np.exp(-np.abs(v) / f.alpha) + f.C2 * np.abs(v)
            torque[:, k] += np.where(v * side > 0.0, side * level, 0.0)
    return torque


def _within(arm: Arm, build: Callable[[float], Motion]) -> Motion:
    limit = np.array([joint.torque_limit or np.inf for joint in arm.joints])
    size = 1.0
    for _ in range(12):
        motion = build(size)
        t = np.arange(0.0, motion.duration, 0.005)
        if np.all(np.abs(needed_torque(arm, *motion.sample(t))) <= SHARE * limit):
            return motion
        size *= 0.8
    return motion


def _scaled(curve: Curve, r: Reach, duration: float, size: float) -> Curve:
    """Return the curve as large as travel, speed and acceleration of the joint allow, times `size`."""
    q, dq, ddq = curve(np.linspace(0.0, duration, 2000))
    middle = 0.5 * (q.max() + q.min())
    factor = size * min(
        r.travel / max(np.ptp(q) / 2.0, 1e-9), r.speed / max(np.abs(dq).max(), 1e-9),
        r.acceleration / max(np.abs(ddq).max(), 1e-9),
    )  # fmt: skip

    def scaled(t: Array) -> tuple[Array, Array, Array]:
        place, rate, change = curve(t)
        return r.centre + factor * (place - middle), factor * rate, factor * change

    return scaled
