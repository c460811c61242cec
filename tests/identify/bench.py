"""One joint driven by the engine as in the paper's section 4: constant velocities, and torques that rise slowly."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from stribeck.arm import Arm, Friction, Joint
from stribeck.run import Run
from stribeck.simulate import Engine, JointLoop, Loop, Reference, close_loop, path_of

FORWARD, BACKWARD = Friction(5.0, 1.25, 1.5, 0.05), Friction(4.3, 1.0, 1.2, 0.06)
SPEEDS = (0.01, 0.02, 0.04, 0.08, 0.15, 0.3, 0.6, 1.0)
OPEN = 0.004  # N m/rad: a reference that runs away fast, so weakly held, is an open-loop ramp of torque


def joint(forward: Friction = FORWARD, backward: Friction = BACKWARD, gravity: float = 0.0) -> Arm:
    own = Joint("A", "revolute", 0.3, 1.0, (0.1, 0.0), 0.5, 0.49, forward, backward)
    return Arm("one joint", (gravity, 0.0), (own,))


@cache
def engine(gravity: float = 0.0) -> Engine:
    return Engine(path_of(joint(gravity=gravity)))


def driven(entry: JointLoop, duration: float, name: str, gravity: float, seed: int) -> Run:
    found = close_loop(engine(gravity), Loop(0.005, duration, (replace(entry, encoder_noise=1e-5),), seed=seed))
    assert found.motion.ok
    return found.run(name)


def sliding(speed: float, gravity: float = 0.0, seed: int = 0) -> Run:
    """A constant velocity, forward or backward, for 3 s."""
    entry = JointLoop("A", 600.0, Reference("ramp", velocity=speed))
    return driven(entry, 3.0, f"slide {speed:g}", gravity, seed)


def breaking(way: int, gravity: float = 0.0, rate: float = 1.6, seed: int = 0) -> Run:
    """A torque that rises by so many N m/s until the joint has moved 0.2 rad."""
    entry = JointLoop("A", OPEN, Reference("ramp", velocity=way * rate / OPEN), kv=0.0)
    run = driven(entry, 1.4 * 6.25 / rate, f"break {way} no. {seed}", gravity, seed)
    end = int(np.argmax(np.abs(run.q[:, 0]) > 0.2)) or len(run.t)
    keys = ("t", "q", "tau", "q_ref", "dq_ref")
    return replace(run, **{key: getattr(run, key)[:end] for key in keys if getattr(run, key) is not None})


def campaign(gravity: float = 0.0) -> list[Run]:
    runs = [sliding(way * speed, gravity, k) for k, speed in enumerate(SPEEDS) for way in (1, -1)]
    return runs + [breaking(way, gravity, seed=k) for k in range(2) for way in (1, -1)]
