"""The paper's bench, simulated: its arm at 80 Hz, and the experiments of sections 4.1 and 4.2."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from stribeck.arm import Arm, Friction, Joint, load_arm
from stribeck.run import Run
from stribeck.simulate import Engine, JointLoop, Loop, Reference, close_loop, path_of

SAMPLE = 0.0125  # s
SPEEDS = (0.0075, 0.015, 0.03, 0.05, 0.075, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0)  # rad/s
TRIALS, READINGS = 4, 10  # at each velocity, and of break-away
STEPS = {"A": 0.02, "B": 0.005}  # N m a sample
SCATTER = 0.05  # relative, of friction from trial to trial
NOISE = 2e-5  # rad, of the encoders
STIFF = 400.0  # N m/rad: below it the slowest velocities stick and slip and have no steady torque
OPEN = 0.004  # N m/rad: a reference that runs away fast, so weakly held, is an open-loop ramp of torque


@cache
def bench() -> Engine:
    """Return the engine of the paper's arm."""
    return Engine(path_of(paper_arm()))


def paper_arm() -> Arm:
    """Return the paper's arm."""
    return load_arm(Path(__file__).with_name("paper_arm.toml"))


@cache
def joint_of_one(name: str) -> Engine:
    """Return a single joint of 1 kg m^2 with the friction of joint A or B."""
    friction = next(joint.friction for joint in paper_arm().joints if joint.name == name)
    return Engine(path_of(_single(friction)))


def _single(friction: Friction) -> Arm:
    return Arm("one joint", (0.0, 0.0), (Joint("A", "revolute", 0.3, 1.0, (0.0, 0.0), 0.5, 0.5, friction, friction),))


def constants(name: str) -> np.ndarray:
    """Return the true C0, C1, C2, alpha of a joint (4,)."""
    friction = next(joint.friction for joint in paper_arm().joints if joint.name == name)
    return np.array([friction.C0, friction.C1, friction.C2, friction.alpha])


def trial(joint: str, moving: JointLoop, duration: float, rng: np.random.Generator, scatter: float = SCATTER) -> Run:
    """Record one trial: a joint under a loop of its own, the other held by a PID, friction other than the last time."""
    engine, factor = bench(), 1.0 + scatter * rng.standard_normal()
    p, keys = engine.p.copy(), [entry.key for entry in engine.path.entries]
    for key in ("C0", "C1", "C2"):
        p[keys.index(f"{joint}.friction.{key}")] *= factor
    other = "B" if joint == "A" else "A"
    held = JointLoop(other, STIFF, Reference("regulate"), ki=200.0, encoder_noise=NOISE)
    loop = Loop(SAMPLE, duration, (moving, held), seed=int(rng.integers(1 << 31)))
    found = close_loop(engine, loop, p=p)
    assert found.motion.ok, found.motion.status
    return found.run(f"{joint}.csv")


def break_away_trial(joint: str, rng: np.random.Generator, scatter: float = SCATTER, faster: float = 1.0) -> Run:
    """Record a torque that rises in the paper's steps until the joint has moved by 0.3 rad."""
    j, rate = "AB".index(joint), faster * STEPS[joint] / SAMPLE
    ramp = JointLoop(joint, OPEN, Reference("ramp", velocity=rate / OPEN), kv=0.0, encoder_noise=NOISE)
    run = trial(joint, ramp, 1.3 * constants(joint)[:2].sum() / rate, rng, scatter)
    end = int(np.argmax(np.abs(run.q[:, j]) > 0.3)) or len(run.t)
    return replace(run, **{key: getattr(run, key)[:end] for key in ("t", "q", "tau", "q_ref", "dq_ref")})


def velocity_trial(joint: str, speed: float, rng: np.random.Generator, kp: float = STIFF, least: float = 4.0) -> Run:
    """Record a constant velocity under PID for 4 to 10 s, at least so many."""
    follow = Reference("ramp", velocity=speed)
    duration = float(np.clip(0.15 / speed, least, max(least, 10.0)))
    return trial(joint, JointLoop(joint, kp, follow, encoder_noise=NOISE), duration, rng)


def campaign(joint: str, rng: np.random.Generator) -> list[Run]:
    """Record all of sections 4.1 and 4.2 for one joint."""
    runs = [velocity_trial(joint, speed, rng) for speed in SPEEDS for _ in range(TRIALS)]
    runs += [break_away_trial(joint, rng) for _ in range(READINGS)]
    return [replace(run, name=f"{joint}_{k:03d}.csv") for k, run in enumerate(runs)]
