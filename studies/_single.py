"""One joint of 1 kg m^2 with the friction of A or B: loops around it, and what is read off them."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from _paper import joint_of_one

from stribeck.arm import Arm, Friction, Joint
from stribeck.simulate import Closed, Compensation, Engine, JointLoop, Loop, Reference, close_loop, path_of


@cache
def coulomb(level: float = 5.0) -> Engine:
    """Return the engine of a joint with Coulomb friction alone."""
    friction = Friction(level, 0.0, 0.0, 0.05)
    return Engine(
        path_of(
            Arm("one joint", (0.0, 0.0), (Joint("A", "revolute", 0.3, 1.0, (0.0, 0.0), 0.5, 0.5, friction, friction),))
        )
    )


def run(
    engine: Engine | str,
    reference: Reference,
    compensation: Compensation | None = None,
    *,
    kp: float = 30.0,
    zeta: float = 1.0,
    sample_time: float = 0.0,
    duration: float = 60.0,
    seed: int = 0,
    **settings: Any,
) -> Closed:
    """Simulate a loop at a damping ratio; continuous unless a sample time is given."""
    joint = JointLoop(
        "A", kp, reference, kv=2.0 * zeta * kp**0.5, compensation=compensation or Compensation(), **settings
    )
    own = joint_of_one(engine) if isinstance(engine, str) else engine
    return close_loop(own, Loop(sample_time, duration, (joint,), record_step=0.005, seed=seed))


def ramp(velocity: float) -> Reference:
    """Return a ramp."""
    return Reference("ramp", velocity=velocity)


def regulate(error: float = 0.5) -> Reference:
    """Return a place to go to, so far away at the start."""
    return Reference("regulate", initial_error=error)


def mean_error(found: Closed) -> float:
    """Return the mean error over the second half, rad."""
    return float(found.error[len(found.error) // 2 :].mean())


def amplitude(found: Closed) -> float:
    """Return half the peak-to-peak position over the last quarter, rad; infinite where the loop is unbounded."""
    return 0.5 * float(np.ptp(found.motion.q[3 * len(found.motion.q) // 4 :, 0])) if found.motion.ok else np.inf


def stuck_share(found: Closed) -> float:
    """Return the share of the second half's time that is spent stuck."""
    stuck, t = found.motion.stuck_time[:, 0], found.motion.t
    half = len(t) // 2
    return float((stuck[-1] - stuck[half]) / (t[-1] - t[half]))


def threshold(engine: str, ratio: float, zeta: float, kp: float = 30.0, low: float = 1e-3, high: float = 0.3) -> float:
    """Return the velocity below which a ramp from rest goes on sticking and slipping, rad/s, by bisection to 1 %."""
    model = Compensation("feedforward", ratio) if ratio else Compensation()
    while high / low > 1.01:
        middle = (low * high) ** 0.5
        slips = stuck_share(run(engine, ramp(middle), model, kp=kp, zeta=zeta, duration=200.0)) > 0.0
        low, high = (middle, high) if slips else (low, middle)
    return (low * high) ** 0.5
