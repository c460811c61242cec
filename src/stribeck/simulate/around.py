"""A sampled control loop around a plant that is not the engine: an FMU, say."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from stribeck.arm import Arm
from stribeck.errors import InputError, StribeckError
from stribeck.simulate.closed import Closed, encoder_noise
from stribeck.simulate.controller import Controller
from stribeck.simulate.loop import Loop
from stribeck.simulate.motion import EVENT, Trajectory

Floats = NDArray[np.float64]

BOUND = 1e4  # rad and rad/s; a loop beyond it is unbounded
_LAG_STEPS = 20  # in which a drive's lag is followed all the way to a new command


@dataclass(frozen=True)
class Reading:
    """What a plant shows at one instant: arrays (n,), not a number where it does not show it.

    Attributes
    ----------
    q, dq : array (n,)
        rad and rad/s.
    mode : array (n,)
        -1 or 1 sliding, 0 stuck.
    friction : array (n,)
        N m.
    """

    q: Floats
    dq: Floats
    mode: Floats
    friction: Floats


class Plant(Protocol):
    """Something that takes torques and shows positions."""

    @property
    def shows_velocity(self) -> bool:
        """Whether readings have velocities."""

    def most_steps(self, sample_time: float) -> int:
        """Return the number of steps that a sample time (s) may be cut into."""

    def start(self, q: Floats) -> Reading:
        """Begin at rest at time 0 in a position (n,), rad."""

    def step(self, time: float, step: float, torque: Floats) -> Reading:
        """Go on from a time (s) by a step (s) under a constant torque (n,), N m; raise `StribeckError` on failure."""


def check_around(arm: Arm, loop: Loop, plant: Plant) -> None:
    """Raise `InputError` where a loop cannot be closed around a plant from outside."""
    if loop.sample_time == 0.0:
        what = "a continuous controller cannot be closed around an FMU"
        raise InputError(what, "sample_time = 0", "give a sample_time above 0")
    free = [name for name in arm.names if name not in {entry.joint for entry in loop.joints}]
    if free:
        raise InputError("an FMU cannot hold a joint still", free[0], "give that joint a controller in the loop file")
    blind = [entry.joint for entry in loop.joints if entry.velocity == "true"]
    if blind and not plant.shows_velocity:
        what = 'velocity = "true" needs the output dq of the FMU, which it has not'
        raise InputError(what, f"joint {blind[0]}", 'write velocity = "finite_difference"')


def close_around(plant: Plant, arm: Arm, loop: Loop) -> Closed:
    """Simulate a sampled control loop around a plant.

    Parameters
    ----------
    plant : Plant
    arm : Arm
        Nominal: what the controllers know of the plant.
    loop : Loop
        Checked against the arm.

    Returns
    -------
    Closed
        Between the samples nothing is seen: time stuck counts the intervals over which a stuck joint's position stays
        the same, and the top speed is that of the samples. There is no state and no log of events.
    """
    check_around(arm, loop, plant)
    controller = Controller(arm, loop)
    count = int(np.floor(loop.duration / loop.sample_time * (1.0 + 1e-12))) + 1
    times = loop.sample_time * np.arange(count, dtype=np.float64)
    noise = encoder_noise(arm, loop, count)
    drive = _Drive(arm, loop, plant.most_steps(loop.sample_time))
    delay = np.array([controller.axes[j].delay for j in range(arm.n)])
    computed, (command, measured) = np.zeros((count, arm.n)), np.full((2, count, arm.n), np.nan)
    readings: list[Reading] = []
    status = "ok"
    now = plant.start(controller.start_position)
    for k in range(count):
        readings.append(now)
        shown = now.q if noise is None else now.q + noise[k]
        measured[k], computed[k] = controller.sample(times[k], shown, now.dq)
        command[k] = [computed[k - d, j] if k >= d else 0.0 for j, d in enumerate(delay)]
        if k + 1 == count:
            break
        try:
            now = drive.through(plant, times[k], command[k])
        except StribeckError as error:
            status = str(error)
            break
        if not np.abs(now.q).max() < BOUND:
            status = "unbounded"
            break
    reference, rate = controller.references(times)
    motion = _trajectory(times, readings, status)
    sees = plant.shows_velocity and all(entry.velocity == "true" for entry in loop.joints)
    ended = float(times[len(readings) - 1])
    return Closed(motion, command, measured, reference, rate, ended, tuple(range(arm.n)), sees)


class _Drive:
    """The lag of each joint's drive, between the sampled command and the plant."""

    def __init__(self, arm: Arm, loop: Loop, most_steps: int) -> None:
        self.lag = np.zeros(arm.n)
        for entry in loop.joints:
            self.lag[arm.names.index(entry.joint)] = entry.actuator_lag
        self.torque = np.zeros(arm.n)
        self.ends = _ends(loop.sample_time, np.unique(self.lag[self.lag > 0.0]), most_steps)

    def through(self, plant: Plant, time: float, command: Floats) -> Reading:
        """Step the plant over one sample, under the mean of the lagged torque over each of many short steps."""
        begin = 0.0
        for end in self.ends:
            h = end - begin
            ratio = np.divide(h, self.lag, out=np.full_like(self.lag, np.inf), where=self.lag > 0.0)
            share = np.where(self.lag > 0.0, -np.expm1(-ratio) / ratio, 0.0)
            away = self.torque - command
            now = plant.step(time + begin, h, command + away * share)
            self.torque, begin = command + away * np.exp(-ratio), end
        return now


def _ends(sample_time: float, lags: Floats, most: int) -> list[float]:
    """Return where the steps of one sample end, s: each lag goes an equal part of its way in each of its own."""
    ends = np.array([sample_time])
    parts = min(_LAG_STEPS, max(most // max(len(lags), 1), 1))
    for lag in lags:
        way = -math.expm1(-sample_time / lag)
        count = math.ceil(parts * way)
        ends = np.append(ends, -lag * np.log1p(-way * np.arange(1, count) / count))
    ends = np.sort(ends[ends > 0.0])
    apart = np.diff(ends, append=np.inf) > 1e-9 * sample_time
    return [*ends[apart & (ends < sample_time * (1.0 - 1e-9))].tolist(), sample_time]


def _trajectory(times: Floats, readings: list[Reading], status: str) -> Trajectory:
    count, filled, n = len(times), len(readings), len(readings[0].q)
    columns: dict[str, Floats] = {}
    for key in ("q", "dq", "mode", "friction"):
        columns[key] = np.full((count, n), np.nan)
        columns[key][:filled] = [getattr(reading, key) for reading in readings]
    sliding = np.nan_to_num(columns["mode"][1:]) != 0.0  # where that is not shown, a joint that stays is stuck
    still = (np.diff(columns["q"], axis=0) == 0.0) & ~sliding
    stuck = np.concatenate([np.zeros((1, n)), np.cumsum(still * np.diff(times)[:, None], axis=0)])
    speed = np.abs(np.diff(columns["q"], axis=0)) / np.diff(times)[:, None]
    speed = np.fmax(np.concatenate([np.zeros((1, n)), speed]), np.abs(columns["dq"]))
    changes = int(np.count_nonzero(np.diff(columns["mode"][:filled], axis=0)))
    return Trajectory(
        times, columns["q"], columns["dq"], columns["mode"], columns["friction"], np.full((count, n), np.nan), stuck,
        speed, np.zeros((count, 0)), np.zeros(0, dtype=EVENT)[["time", "joint", "before", "after"]], status, filled,
        changes, 0,
    )  # fmt: skip
