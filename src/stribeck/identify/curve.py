"""Readings of friction from recordings: steady sliding, and break-away under a torque that rises slowly.

The paper holds the velocity constant and takes the applied torque for friction (section 4.2), and lets the torque rise
in small steps until the joint moves (4.1). Here such stretches are found in any recording, and what the rigid body
itself needs (gravity, the other joints' motion, what is left of acceleration) is taken off.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from stribeck.identify.beyond import Beyond
from stribeck.identify.conditioning import Conditioned
from stribeck.identify.residual import Residual
from stribeck.model.forward import Forward
from stribeck.model.path import SignalPath

Floats = NDArray[np.float64]

COLUMNS = {1: 0, -1: 1}  # of friction forward, and backward
PART = 0.125  # s; velocity is compared between parts of this length, by straight lines through the positions
LEAST_PARTS = 4  # so that steady sliding lasts half a second at least
STEADY = 0.05  # relative departure of a part's velocity from the stretch's
STILL_TIME = 0.25  # s of rest before a break-away
SEEN = 5.0  # deviations of position noise by which a joint must have left its place
SLOW = 0.2  # the torque may rise by this share of itself while the joint is watched at rest


@dataclass(frozen=True)
class Point:
    """One trial of one joint.

    Attributes
    ----------
    joint, direction : int
        Index, and 1 or -1.
    speed : float
        Absolute velocity, rad/s; 0 is a break-away reading.
    torque : float
        Friction against the motion, N m.
    samples : int
        Samples that were averaged.
    run : str
        The recording's name.
    """

    joint: int
    direction: int
    speed: float
    torque: float
    samples: int
    run: str


def read_points(path: SignalPath, p: Floats, runs: Sequence[Conditioned]) -> tuple[Point, ...]:
    """Return every trial in the runs.

    Parameters
    ----------
    path : SignalPath
        Its rigid body, and what the effects of the arm file do, their part in friction too, are taken off the command.
    p : array (p,)
        Parameter values of the path.
    runs : sequence of Conditioned
        Not thinned.

    Notes
    -----
    Stretches of one run at one velocity are one trial, as are its break-aways in one direction: what differs from trial
    to trial (the paper's torques scatter) does not average out within one.
    """
    points: list[Point] = []
    inertia = _inertia(path, p, runs)
    residual = Residual(path, runs, ())
    beyond = Beyond(residual)
    for run in runs:
        stages = residual.stages(run, p)
        scale = _command_scale(path, p, run)
        friction = scale * (stages["actuator"] - stages["rotor"] - stages["load"])
        # right in the mean, but not before a break-away: there the command counts as it was held, and the joint is
        # still, whatever acceleration the smoothing carries back in time
        held = friction + scale * (run.run.tau - run.command) + inertia * run.acceleration
        added = beyond(run, p)
        for j in range(path.n):
            found = _sliding(run, j, friction[:, j, None] - added[:, j])
            found += _break_aways(run, j, held[:, j, None] - added[:, j], float(inertia[j]))
            points += _trials(found)
    return tuple(points)


def _trials(found: list[Point]) -> list[Point]:
    """Merge readings of one run, joint and direction whose velocities agree."""
    merged: list[Point] = []
    for point in sorted(found, key=lambda one: (one.direction, one.speed)):
        last = merged[-1] if merged else None
        if last and last.direction == point.direction and point.speed - last.speed <= STEADY * point.speed:
            samples = last.samples + point.samples
            share = point.samples / samples
            speed = (1 - share) * last.speed + share * point.speed
            torque = (1 - share) * last.torque + share * point.torque
            merged[-1] = Point(point.joint, point.direction, speed, torque, samples, point.run)
        else:
            merged.append(point)
    return merged


def _sliding(run: Conditioned, joint: int, friction: Floats) -> list[Point]:
    """Return the stretches of steady sliding of one joint; friction (N, 2) as it is forward, and backward."""
    h = run.sample_time
    width = max(5, round(PART / h))
    q = run.run.q[:, joint]
    count = len(q) // width
    if count < LEAST_PARTS:
        return []
    parts = q[: count * width].reshape(count, width)
    clock = h * (np.arange(width) - 0.5 * (width - 1))
    slope = parts @ clock / (clock @ clock)
    unsure = 3.0 * float(run.noise[joint]) / float(np.sqrt(clock @ clock))
    found = []
    edge = len(run.taps) // 2  # where smoothing makes accelerations of its own
    for first, last in _steady(slope, unsure):
        rows = slice(max(first * width, edge), min(last * width, len(q) - edge))
        if rows.stop - rows.start < LEAST_PARTS * width // 2:
            continue
        speed = float(np.mean(slope[first:last]))
        way = 1 if speed > 0.0 else -1
        torque = way * float(np.mean(friction[rows, COLUMNS[way]]))
        found.append(Point(joint, way, abs(speed), torque, rows.stop - rows.start, run.name))
    return [point for point in found if point.torque > 0.0]


def _steady(slope: Floats, unsure: float) -> list[tuple[int, int]]:
    """Return the longest stretches (first, past the last part) in which velocity stays the same, from left to right."""
    stretches = []
    first = 0
    while first + LEAST_PARTS <= len(slope):
        last = first
        low = high = total = float(slope[first])
        while last + 1 < len(slope):
            value = float(slope[last + 1])
            mean = (total + value) / (last + 2 - first)
            reach = STEADY * abs(mean) + unsure
            if max(high, value) - mean > reach or mean - min(low, value) > reach:
                break
            low, high, total, last = min(low, value), max(high, value), total + value, last + 1
        mean = total / (last + 1 - first)
        if last + 1 - first >= LEAST_PARTS and abs(mean) > 3.0 * unsure:
            stretches.append((first, last + 1))
            first = last + 1
        else:
            first += 1
    return stretches


def _break_aways(run: Conditioned, joint: int, held: Floats, inertia: float) -> list[Point]:
    """Return the break-away readings of one joint; what is ``held`` (N, 2) as it is forward, and backward.

    Notes
    -----
    A joint that has broken away is not seen to move at once: under a torque that rises at the rate r past the level it
    has moved by q = r s^3 / (6 J) after s seconds. The torque at which it is first seen is read back by r s.
    """
    h, q = run.sample_time, run.run.q[:, joint]
    still, after = max(8, round(STILL_TIME / h)), 3
    if len(q) < still + after + 1:
        return []
    # a little over twice the noise, which a quantised encoder understates
    edge = max(SEEN * float(run.noise[joint]), 1e-9)
    windows = sliding_window_view(q, still + after)
    rest = np.median(windows[:, :still], axis=1)
    moved = windows[:, still:] - rest[:, None]
    # a sample that has just left may be followed by one that has not: it still counts as quiet
    quiet = np.abs(windows[:, :still] - rest[:, None]).max(axis=1) <= 1.4 * edge
    left = np.abs(moved).min(axis=1) > edge
    left &= (np.sign(moved) == np.sign(moved[:, :1])).all(axis=1)
    found = []
    for k in np.flatnonzero(quiet & left):
        if k and quiet[k - 1] and left[k - 1]:
            continue
        way = int(np.sign(moved[k, 0]))
        clock = h * np.arange(-still, 0)
        rate, level = np.polynomial.polynomial.polyfit(clock, way * held[k : k + still, COLUMNS[way]], 1)[::-1]
        lag = (6.0 * inertia * edge / rate) ** (1 / 3) if rate > 0.0 else np.inf
        lag += h * _after_crossing(way * (windows[k, still - 1 : still + 1] - rest[k]), edge)
        torque = level - rate * (lag + 0.5 * h)  # a held torque is half a step behind its own straight line
        if rate > 0.0 and torque > 0.0 and rate * STILL_TIME < SLOW * torque and lag < STILL_TIME:
            found.append(Point(joint, way, 0.0, float(torque), still, run.name))
    return found


def _after_crossing(moved: Floats, edge: float) -> float:
    """Return how far, in samples, the second of two displacements lies after the edge that they pass, as t^3 grows."""
    before, after = np.cbrt(np.maximum(moved, 0.0))
    return float((after - np.cbrt(edge)) / (after - before))


def _command_scale(path: SignalPath, p: Floats, run: Conditioned) -> Floats:
    """Return what one N m of command is worth at each joint and sample (N, n)."""
    q = ca.SX.sym("q", path.n)
    scale = ca.vertcat(*[ca.SX(path.command_scale(j, q[j])) for j in range(path.n)])
    worth = ca.Function("scale", [path.p, q], [scale]).map(len(run.position))
    return np.asarray(worth(np.repeat(p[:, None], len(run.position), axis=1), run.position.T).full().T)


def _inertia(path: SignalPath, p: Floats, runs: Sequence[Conditioned]) -> Floats:
    """Return the mean inertia (n,) that each joint moves in the poses of the runs, kg m^2."""
    poses = np.concatenate([run.position[:: max(1, len(run.position) // 20)] for run in runs])
    moved = Forward(path).inertia.map(len(poses))
    return np.asarray(moved(poses.T, np.repeat(p[:, None], len(poses), axis=1)).full().mean(axis=1))
