"""Laws of effects as formulas: the torque that one unit of each asks for along a recorded motion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy import signal
from scipy.interpolate import CubicSpline

from stribeck.run import Run

Floats = np.ndarray
SMOOTH = 20.0  # Hz, of the zero-phase filter
SELDOM = 0.85  # of all samples, beyond which a wall begins
CREEP = 0.03  # rad/s, over which friction changes its sign


@dataclass(frozen=True)
class Motion:
    """One joint of a recording, each (N,), and the other joint's command: s, rad, rad/s, N m.

    ``far`` is where it seldom goes in any of the recordings, rad.
    """

    time: Floats
    position: Floats
    velocity: Floats
    command: Floats
    other: Floats
    far: float = np.inf

    @property
    def sign(self) -> Floats:
        return np.asarray(np.tanh(self.velocity / CREEP))


def motion(run: Run, joint: int) -> Motion:
    """Return a joint's smoothed motion and command along a recording of a two-link arm."""
    rate = 1.0 / float(np.median(np.diff(run.t)))
    low = signal.butter(3, SMOOTH, fs=rate, output="sos")
    position, command = (signal.sosfiltfilt(low, values, axis=0) for values in (run.q, run.tau))
    velocity = signal.sosfiltfilt(low, CubicSpline(run.t, position)(run.t, 1), axis=0)
    return Motion(run.t, position[:, joint], velocity[:, joint], command[:, joint], command[:, 1 - joint])


LAWS: dict[str, Callable[[Motion], Floats]] = {
    "torque_offset": lambda m: np.ones_like(m.time),
    "quadratic_damping": lambda m: m.velocity * np.abs(m.velocity),
    "position_dependent_friction": lambda m: m.sign * np.sin(2.0 * m.position + 0.7),
    "cogging": lambda m: np.sin(8.0 * m.position + 0.4),
    "torque_ripple": lambda m: m.command * np.sin(6.0 * m.position + 1.0),
    "cable_spring": lambda m: m.position - 0.3,
    "contact": lambda m: np.maximum(m.position - m.far, 0.0) ** 1.5,
    "torque_dead_zone": lambda m: np.tanh(m.command / 0.01),
    "input_disturbance": lambda m: np.sin(2.0 * np.pi * 2.3 * m.time),
    "cross-talk of drives": lambda m: m.other,
}
OUTSIDE = ("cross-talk of drives",)


def put_in(runs: list[Run], law: str, joint: int, rms: float) -> list[Run]:
    """Return the runs as they would have been with an effect that takes a torque of so many N m rms at a joint."""
    motions = [motion(run, joint) for run in runs]
    far = float(np.quantile(np.concatenate([m.position for m in motions]), SELDOM))
    torques = [LAWS[law](replace(m, far=far)) for m in motions]
    factor = rms / float(np.sqrt(np.mean(np.concatenate(torques) ** 2)))
    out = []
    for run, torque in zip(runs, torques, strict=True):
        tau = run.tau.copy()
        tau[:, joint] += factor * torque
        out.append(replace(run, tau=tau, tau_meas=None))
    return out
