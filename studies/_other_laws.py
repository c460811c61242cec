"""Laws of effects as textbooks have them, not as the library has: torques along a recorded motion, by formula."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import signal

from stribeck.arm import Arm
from stribeck.run import Run
from stribeck.withheld.plant import rigid_torque

Floats = np.ndarray
SMOOTH = 25.0  # Hz, of the zero-phase filter
STILL = 2e-3  # of the largest speed: slower is at rest, where friction goes from the one side's value to the other's


@dataclass(frozen=True)
class Ride:
    """One joint of a recording, each (N,), SI.

    ``position`` and ``velocity`` are from their mean, over their deviation; ``sign`` and ``level`` are friction's, and
    ``friction`` all of it. ``before`` is how long the joint had moved in the recordings before, of which there were
    ``number``, and ``gone`` how far until now.
    """

    time: Floats
    position: Floats
    velocity: Floats
    sign: Floats
    level: Floats
    friction: Floats
    load: Floats
    command: Floats
    angle: Floats
    before: float
    gone: Floats
    number: int


def rides(arm: Arm, runs: Sequence[Run], joint: int) -> list[Ride]:
    """Return a joint's rides in the order of the recordings; positions and velocities of all have one scale."""
    moves = [_motion(run) for run in runs]
    angle = np.concatenate([q[:, joint] for q, _, _ in moves])
    speed = float(np.sqrt(np.mean(np.concatenate([v[:, joint] for _, v, _ in moves]) ** 2)))
    links = replace(arm, joints=tuple(replace(one, rotor_inertia=0.0) for one in arm.joints))
    constants, before, gone, found = arm.joints[joint].friction, 0.0, 0.0, []
    for number, (run, (q, v, a)) in enumerate(zip(runs, moves, strict=True)):
        velocity, time = v[:, joint], run.t - run.t[0]
        sign = _sign(velocity)
        level = constants.C0 + constants.C1 * np.exp(-np.abs(velocity) / constants.alpha)
        way = gone + np.cumsum(np.abs(velocity)) * run.sample_time
        found.append(
            Ride(
                time, (q[:, joint] - angle.mean()) / angle.std(), velocity / speed, sign, level,
                sign * level + constants.C2 * velocity, rigid_torque(links, q, v, a)[:, joint], run.tau[:, joint],
                q[:, joint], before, way, number,
            )
        )  # fmt: skip
        before, gone = before + float(time[-1]), float(way[-1])
    return found


def _motion(run: Run) -> tuple[Floats, Floats, Floats]:
    rate = 1.0 / run.sample_time
    low = signal.butter(3, min(SMOOTH, 0.35 * rate), fs=rate, output="sos")
    q = signal.sosfiltfilt(low, run.q, axis=0)
    v = np.gradient(q, run.sample_time, axis=0)
    return q, v, np.gradient(v, run.sample_time, axis=0)


def _sign(velocity: Floats) -> Floats:
    moves, rows = np.abs(velocity) > STILL * np.max(np.abs(velocity)), np.arange(len(velocity))
    return np.asarray(np.interp(rows, rows[moves], np.sign(velocity[moves])))


def _later(values: Floats, time: Floats, by: float) -> Floats:
    return np.asarray(np.interp(time - by, time, values))


def _bell(r: Ride) -> Floats:
    return np.asarray(np.exp(-((r.position / 0.4) ** 2)))


def _steps(r: Ride) -> Floats:
    levels = np.random.default_rng(r.number).normal(size=1 + int(r.time[-1] / 0.4))
    return np.asarray(levels[(r.time / 0.4).astype(int)])


LAWS: dict[str, tuple[str, Callable[[Ride], Floats]]] = {
    "level of both sides": ("asymmetric_friction", lambda r: np.abs(r.sign)),
    "slope of one side": ("asymmetric_friction", lambda r: np.maximum(r.velocity, 0.0)),
    "level of before": (
        "frictional_lag",
        lambda r: r.sign * (_later(r.level, r.time, 0.03) - r.level),
    ),
    "two waves, 3 and 7": (
        "position_dependent_friction",
        lambda r: r.sign * r.level * (np.sin(3 * r.angle + 0.3) + 0.6 * np.sin(7 * r.angle + 1.0)),
    ),
    "one worn spot": ("position_dependent_friction", lambda r: r.sign * r.level * _bell(r)),
    "more on one side": ("position_dependent_friction", lambda r: r.sign * r.level * r.position),
    "cube of the speed": ("quadratic_damping", lambda r: r.velocity**3),
    "share of the load's root": ("load_dependent_friction", lambda r: r.sign * np.sqrt(np.abs(r.load))),
    "of load and command": ("load_dependent_friction", lambda r: r.sign * np.abs(r.load + r.command)),
    "anew with each run": ("history", lambda r: r.friction * np.exp(-r.time / 4.0)),
    "with time, run after run": ("history", lambda r: r.friction * np.exp(-(r.before + r.time) / 20.0)),
    "with time, evenly": ("history", lambda r: r.friction * (r.before + r.time)),
    "with the way gone": ("history", lambda r: r.friction * np.exp(-r.gone / 30.0)),
    "another level each run": (
        "history",
        lambda r: r.friction * np.random.default_rng(r.number).uniform(-1.0, 1.0),
    ),
    "three waves": (
        "cogging",
        lambda r: np.sin(6 * r.angle) + 0.6 * np.sin(12 * r.angle + 1.0) + 0.5 * np.sin(18 * r.angle + 2.0),
    ),
    "cube of the way": ("cable_spring", lambda r: r.position**3),
    "taut on one side": ("cable_spring", lambda r: np.maximum(r.position, 0.0)),
    "spring and damper": (
        "contact",
        lambda r: np.where(r.position > 1.2, np.maximum(r.position - 1.2 + 0.1 * r.velocity, 0.0), 0.0),
    ),
    "square wave": ("input_disturbance", lambda r: np.sign(np.sin(2 * np.pi * 1.3 * r.time + r.number))),
    "two tones": (
        "input_disturbance",
        lambda r: np.sin(2 * np.pi * 2.1 * r.time + r.number) + np.sin(2 * np.pi * 5.3 * r.time),
    ),
    "steps at random": ("input_disturbance", _steps),
    "a share of the command": ("torque_gain", lambda r: r.command),
    "lost on either side": ("torque_dead_zone", lambda r: np.tanh(r.command / (0.01 * np.std(r.command)))),
}


def put_in(arm: Arm, runs: Sequence[Run], joint: int, law: str, share: float) -> list[Run]:
    """Return the runs as they would have been with a law that takes a share of the joint's torque, both rms."""
    torques = [LAWS[law][1](ride) for ride in rides(arm, runs, joint)]
    size, torque = (np.sqrt(np.mean(np.concatenate(x) ** 2)) for x in (torques, [run.tau[:, joint] for run in runs]))
    out = []
    for run, more in zip(runs, torques, strict=True):
        tau = run.tau.copy()
        tau[:, joint] += share * torque / size * more
        out.append(replace(run, tau=tau))
    return out
