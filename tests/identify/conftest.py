"""Recordings made by formulas: a pendulum that follows a given motion, driven by the torque that its law asks for."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from stribeck.arm import Arm, Friction, Joint, Tolerance
from stribeck.run import Run

FRICTION = Friction(2.0, 0.5, 0.7, 0.05)
PENDULUM = Joint("A", "revolute", 0.3, 2.0, (0.2, 0.0), 0.03, 0.05, FRICTION, FRICTION)


def pendulum(gravity: float = 9.81) -> Arm:
    return Arm("pendulum", (gravity, 0.0), (PENDULUM,), tolerance=Tolerance(0.1, 0.3))


def law(joint: Joint, gravity: float, q: np.ndarray, dq: np.ndarray, ddq: np.ndarray) -> np.ndarray:
    """Torque of a pendulum with Tustin friction, textbook form; q, dq, ddq (N,)."""
    m, r, f = joint.mass, joint.com[0], joint.friction
    dry = np.sign(dq) * (f.C0 + f.C1 * np.exp(-np.abs(dq) / f.alpha)) + f.C2 * dq
    return (joint.inertia + m * r**2 + joint.rotor_inertia) * ddq + m * gravity * r * np.sin(q) + dry


def sines(t: np.ndarray, amplitude: float = 0.5, hertz: tuple[float, ...] = (0.5, 1.3)) -> list[np.ndarray]:
    """Position, velocity and acceleration of a sum of sines, each (N,)."""
    omega = [2 * math.pi * f for f in hertz]
    q = sum(amplitude / k * np.sin(w * t + k) for k, w in enumerate(omega, 1))
    dq = sum(amplitude / k * w * np.cos(w * t + k) for k, w in enumerate(omega, 1))
    ddq = sum(-amplitude / k * w**2 * np.sin(w * t + k) for k, w in enumerate(omega, 1))
    return [np.asarray(x) for x in (q, dq, ddq)]


def recorded(
    joint: Joint = PENDULUM,
    gravity: float = 9.81,
    *,
    rate: float = 500.0,
    duration: float = 6.0,
    noise: float = 0.0,
    step: float = 0.0,
    seed: int = 0,
) -> Run:
    """A run whose command, averaged as a held one is, is what the law asks for."""
    t = np.arange(round(duration * rate)) / rate
    q, _, _ = sines(t)
    tau = law(joint, gravity, *sines(t + 0.5 / rate))  # held: two neighbours' mean is the law's value in between
    q = q + noise * np.random.default_rng(seed).standard_normal(len(q))
    q = np.round(q / step) * step if step else q
    return Run("sines", t, q[:, None], tau[:, None])


def hoisted(own: Joint, *, noise: float = 0.0, seed: int = 0) -> tuple[Arm, Run]:
    """A vertical axis with the values of ``own``, and its run: gravity holds against it with the same force always."""
    axis = replace(own, kind="prismatic", length=0.0, com=(0.0, 0.0), inertia=0.0)
    moved = replace(axis, rotor_inertia=axis.rotor_inertia + axis.mass)  # the law's, of a joint that turns
    run = recorded(moved, 0.0, rate=250.0, noise=noise, seed=seed)
    arm = Arm("hoist", (9.81, 0.0), (axis,), tolerance=Tolerance(0.1, 0.3))
    return arm, replace(run, tau=run.tau - 9.81 * axis.mass)


def stronger(joint: Joint, **factors: float) -> Joint:
    """The joint with some constants multiplied: mass, inertia, or friction constants."""
    friction = replace(
        joint.friction, **{k: v * getattr(joint.friction, k) for k, v in factors.items() if hasattr(joint.friction, k)}
    )
    own = {k: v * getattr(joint, k) for k, v in factors.items() if not hasattr(joint.friction, k)}
    return replace(joint, friction=friction, backward=friction, **own)


@pytest.fixture
def arm() -> Arm:
    return pendulum()
