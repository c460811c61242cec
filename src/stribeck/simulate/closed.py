"""Closed loops: a controller around the engine, all in C."""

from __future__ import annotations

import ctypes
import os
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from joblib import Parallel, delayed
from numpy.typing import NDArray

from stribeck.arm import Arm
from stribeck.run import Run
from stribeck.simulate.axis import axes_of, start_position
from stribeck.simulate.engine import Engine, array_of, path_of, pointer
from stribeck.simulate.loop import Loop
from stribeck.simulate.motion import EVENT, Trajectory

Floats = NDArray[np.float64]

BOUND = 1e4  # rad and rad/s; a loop beyond it is unbounded


@dataclass(frozen=True)
class Closed:
    """A closed-loop simulation of M rows and n joints.

    Attributes
    ----------
    motion : Trajectory
        What the arm did.
    command : array (M, n)
        Commanded torque, N m.
    measured : array (M, n)
        What the encoders gave, noise and resolution included, rad.
    reference, reference_rate : array (M, n)
        rad and rad/s; a clamped joint's own position.
    ended : float
        The time that was reached, s; short of the duration only where ``motion.status`` is not ``ok``.
    controlled : tuple of int
        Joints with a controller.
    sees_velocity : bool
        Whether all controllers measure velocity, so that a recording has it.
    """

    motion: Trajectory
    command: Floats
    measured: Floats
    reference: Floats
    reference_rate: Floats
    ended: float
    controlled: tuple[int, ...]
    sees_velocity: bool

    @property
    def error(self) -> Floats:
        """Reference less measured position (M, n), rad."""
        return self.reference - self.measured

    def run(self, name: str) -> Run:
        """Return the recording of the rows that were reached."""
        rows = slice(0, self.motion.filled)
        return Run(
            name=name,
            t=self.motion.t[rows],
            q=self.measured[rows],
            tau=self.command[rows],
            dq=self.motion.dq[rows] if self.sees_velocity else None,
            q_ref=self.reference[rows],
            dq_ref=self.reference_rate[rows],
        )


def simulate_loop(arm: Arm, loop: Loop, *, tolerance: float = 1e-8) -> Closed:
    """Simulate a control loop around an arm with the effects of its file."""
    return close_loop(Engine(path_of(arm)), loop, tolerance=tolerance)


def simulate_many(engine: Engine, loops: Sequence[Loop], *, tolerance: float = 1e-8, jobs: int = -1) -> list[Closed]:
    """Simulate many loops around one arm, on all cores (``jobs`` as in joblib)."""
    _ = engine.library  # built once, before the threads want it
    count = os.cpu_count() or 1 if jobs == -1 else jobs
    work = (delayed(close_loop)(engine, loop, tolerance=tolerance) for loop in loops)
    return list(Parallel(n_jobs=count, prefer="threads")(work))


def close_loop(
    engine: Engine,
    loop: Loop,
    *,
    p: Floats | None = None,
    tolerance: float = 1e-8,
    most_events: int = 10_000,
) -> Closed:
    """Simulate a control loop around an engine's arm.

    Parameters
    ----------
    engine : Engine
    loop : Loop
        Checked (`stribeck.simulate.loopfile.check_loop`).
    p : array (p,) or None
        Parameter values of the arm in place of its own; the controller keeps the arm's.
    tolerance : float
        Of one step's error, relative and absolute.
    most_events : int
        So many are kept.
    """
    arm = engine.path.arm
    values = engine.p if p is None else array_of(p, (len(engine.path.entries),), "p")
    count = int(np.floor(loop.duration / loop.step * (1.0 + 1e-12))) + 1
    times = loop.step * np.arange(count, dtype=np.float64)
    start = start_position(arm, loop)
    axes, tables = axes_of(arm, loop, engine.moved_inertia(start))
    noise, log = encoder_noise(arm, loop, count), np.zeros(most_events, dtype=EVENT)
    out = _call(engine, values, tolerance, axes, loop.sample_time, times, engine.start(values, start), noise, log)
    command, measured, signals, modes, states, info, ended = out
    motion = Trajectory.of(times, signals, modes, states, log, info)
    reference, rate = _references(engine, axes, times, start)
    del tables  # the axes pointed into them until now
    controlled = tuple(arm.names.index(entry.joint) for entry in loop.joints)
    sees = loop.sample_time == 0.0 or all(entry.velocity == "true" for entry in loop.joints)
    return Closed(motion, command, measured, reference, rate, float(ended[0]), controlled, sees)


def _call(
    engine: Engine, p: Floats, tolerance: float, axes: object, sample_time: float, times: Floats, state: Floats,
    noise: Floats | None, log: np.ndarray,
) -> tuple[Floats, Floats, Floats, Floats, Floats, np.ndarray, Floats]:  # fmt: skip
    """Return command, measured position, signals, modes, states, info and the time reached."""
    count, n = len(times), engine.n
    command, computed, measured = np.full((count, n), np.nan), np.zeros((count, n)), np.full((count, n), np.nan)
    signals, modes = np.full((count, 6, n), np.nan), np.full((count, n), np.nan)
    states, info, ended = np.full((count, engine.size), np.nan), np.zeros(4, dtype=np.int64), np.zeros(1)
    engine.library.sb_closed_loop(
        pointer(p), ctypes.c_double(tolerance), ctypes.c_double(BOUND), axes, ctypes.c_double(sample_time),
        pointer(times), ctypes.c_longlong(count), pointer(state), pointer(noise), pointer(command),
        pointer(computed), pointer(measured), pointer(signals), pointer(modes), pointer(states), pointer(info),
        pointer(ended), pointer(log), ctypes.c_longlong(len(log)),
    )  # fmt: skip
    return command, measured, signals, modes, states, info, ended


def encoder_noise(arm: Arm, loop: Loop, count: int) -> Floats | None:
    """Return the noise (count, n) of the encoders, rad; None where there is none."""
    sd = np.zeros(arm.n)
    for entry in loop.joints:
        sd[arm.names.index(entry.joint)] = entry.encoder_noise
    if not sd.any():
        return None
    return np.random.default_rng(loop.seed).standard_normal((count, arm.n)) * sd


def _references(engine: Engine, axes: object, times: Floats, start: Floats) -> tuple[Floats, Floats]:
    position, rate = np.tile(start, (len(times), 1)), np.zeros((len(times), engine.n))
    engine.library.sb_references(axes, pointer(times), ctypes.c_longlong(len(times)), pointer(position), pointer(rate))
    return position, rate
