"""The tip of the two-link arm against a compliant wall: the arm, its PIDs and the wall, a millisecond at a time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from _paper import bench

from stribeck.run import Run

STEP = 1e-3  # s: the wall pushes with a torque held so long, and so do the controllers
STIFFNESS, DAMPING = 300.0, 5.0  # N/m, N s/m
GAINS = np.array([400.0, 400.0])  # N m/rad, of either joint; critically damped


@dataclass(frozen=True)
class Pressing:
    """A recording with the tip force (N, 2) that the force sensor gives, on the arm, N."""

    run: Run
    force: np.ndarray


def tip(q: np.ndarray) -> np.ndarray:
    """Return the tip's position (2,), m."""
    a, b = (joint.length for joint in bench().path.arm.joints)
    return np.array([a * np.cos(q[0]) + b * np.cos(q.sum()), a * np.sin(q[0]) + b * np.sin(q.sum())])


def jacobian(q: np.ndarray) -> np.ndarray:
    """Return d(tip)/dq (2, 2), m."""
    a, b = (joint.length for joint in bench().path.arm.joints)
    second = b * np.array([-np.sin(q.sum()), np.cos(q.sum())])
    return np.stack([a * np.array([-np.sin(q[0]), np.cos(q[0])]) + second, second], axis=1)


def press(start: np.ndarray, velocity: np.ndarray, duration: float, wall: float, noise: float, seed: int) -> Pressing:
    """Drive both joints at constant velocities under PD, the tip into a wall at a height y (m); record.

    Parameters
    ----------
    start, velocity : array (2,)
        Where the joints begin, rad, and how fast they shall go, rad/s.
    noise : float
        Standard deviation of the force sensor, N.
    """
    engine, rng = bench(), np.random.default_rng(seed)
    state, modes = engine.start(engine.p, start), np.zeros(2)
    rows: list[list[np.ndarray]] = []
    for k in range(round(duration / STEP)):
        q, dq = state[:2], state[2:4]
        error, rate = start + velocity * k * STEP - q, velocity - dq
        applied = GAINS * error + 2.0 * np.sqrt(GAINS) * rate
        depth, push = tip(q)[1] - wall, 0.0
        if depth > 0.0:
            push = max(0.0, STIFFNESS * depth + DAMPING * float((jacobian(q) @ dq)[1]))
        force = np.array([0.0, -push])
        rows.append([q, dq, applied, force + noise * rng.standard_normal(2)])
        torque = np.tile(applied + jacobian(q).T @ force, (2, 1))
        moved = engine.run(engine.p, state, np.array([0.0, STEP]), torque, modes=modes, tolerance=1e-6)
        state, modes = moved.state[-1], moved.modes[-1]
    q, dq, applied, force = (np.array(column) for column in zip(*rows, strict=True))
    return Pressing(Run("contact", STEP * np.arange(len(q)), q, applied, dq=dq), force)
