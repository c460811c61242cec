"""A bench for the plant: arms of known size, and open-loop runs of the bare plant."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from stribeck.arm import Arm, Friction, Joint
from stribeck.withheld.injections import assemble
from stribeck.withheld.plant import Drive, Trace, simulate

SMOOTH = Friction(0.0, 0.0, 0.0, 0.1)
A = Friction(4.6, 1.65, 1.4, 0.06)
B = Friction(2.2, 0.6, 0.8, 0.04)


def two_link(gravity: tuple[float, float] = (0.0, 0.0), rough: bool = True) -> Arm:
    a, b = (A, B) if rough else (SMOOTH, SMOOTH)
    return Arm(
        "bench arm",
        gravity,
        (
            Joint("A", "revolute", 0.35, 4.0, (0.17, 0.02), 0.06, 0.15, a, a, 200.0),
            Joint("B", "revolute", 0.30, 2.0, (0.13, -0.01), 0.02, 0.05, b, b, 60.0),
        ),
    )


def one_link(gravity: tuple[float, float] = (0.0, 0.0), friction: Friction = SMOOTH, **changes: float) -> Arm:
    joint = Joint("A", "revolute", 0.3, 1.0, (0.25, 0.0), 0.01, 0.02, friction, friction)
    return Arm("one joint", gravity, (replace(joint, **changes),))


def open_loop(
    arm: Arm,
    torque: Callable[[np.ndarray], np.ndarray],
    duration: float,
    effects: tuple = (),
    start: tuple[tuple[float, float], ...] | None = None,
    rate: float = 1000.0,
    substeps: int = 0,
) -> tuple[np.ndarray, Trace]:
    """Drive the plant by a torque (N,) -> (N, n) without a controller; return the times and the trace."""
    t = np.arange(round(duration * rate) + 1) / rate
    n = arm.n
    ones = np.ones((len(t) + 1, n))
    begin = np.array(start or [(0.0, 0.0)] * n)
    zeros = np.zeros((len(t), n))
    drive = Drive(
        1.0 / rate, np.zeros((len(t), n, 2)), np.broadcast_to(torque(t), (len(t), n)), zeros, 0.0 * ones, ones,
        begin, np.zeros(n), substeps,
    )  # fmt: skip
    return t, simulate(assemble(arm, effects).plant, drive)


@pytest.fixture
def bench():
    class Bench:
        two_link = staticmethod(two_link)
        one_link = staticmethod(one_link)
        open_loop = staticmethod(open_loop)
        A, B, SMOOTH = A, B, SMOOTH

    return Bench
