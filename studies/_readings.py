"""Two ways to read a break-away torque off a recording."""

from __future__ import annotations

import numpy as np

from stribeck.identify.conditioning import condition
from stribeck.identify.curve import read_points
from stribeck.run import Run
from stribeck.simulate import Engine

SEEN = 5.0  # deviations of the finite difference's noise


def first_seen(engine: Engine, run: Run, joint: str) -> float:
    """Return the torque at the first of three samples in a row whose velocity stands out of the noise, N m."""
    j, rest = "AB".index(joint), 40
    velocity = np.diff(run.q[:, j]) / run.sample_time
    loud = np.abs(velocity) > SEEN * np.std(velocity[:rest])
    three = loud[:-2] & loud[1:-1] & loud[2:]
    return float(run.tau[int(np.argmax(three)), j])


def read_back(engine: Engine, run: Run, joint: str) -> float:
    """Return the reading of `stribeck.identify.curve`, N m; not a number where it does not take the ramp for one."""
    data = condition(engine.path.arm, run, 5.0)
    points = read_points(engine.path, engine.p, [data])
    torques = [point.torque for point in points if point.joint == "AB".index(joint) and point.speed == 0.0]
    return torques[0] if torques else float("nan")
