"""What the rest of a loop does with one harmonic: the linear part, the estimator and the way of the command."""

from __future__ import annotations

import math
from dataclasses import dataclass

import control as ct
import numpy as np
from numpy.typing import NDArray

from stribeck.arm import Arm
from stribeck.errors import InputError
from stribeck.loop.linear.controller import controller, derivative_gain, tuned_inertia
from stribeck.loop.linear.operating import OperatingPoint, pose
from stribeck.loop.linear.plant import linearise
from stribeck.simulate.loop import JointLoop, Loop

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class LinearPart:
    """All of a joint's loop but friction and its compensation, harmonic by harmonic; the other joints held.

    A sampled controller is taken by what it does to the fundamental of each harmonic: hold, delays, lag and estimator
    are exact there, the images above the Nyquist frequency are left out.

    Attributes
    ----------
    plant : control.StateSpace
        From the torque at the motor to its position and velocity.
    drive : control.StateSpace or None
        Plant from the command, where the arm has actuator effects.
    delay : float
        Of the arm's own effects, s.
    entry : JointLoop
    kv : float
        Derivative gain in force, N m s/rad.
    inertia : float
        kg m^2.
    sample_time : float
        s; 0 is continuous.
    """

    plant: ct.StateSpace
    drive: ct.StateSpace | None
    delay: float
    entry: JointLoop
    kv: float
    inertia: float
    sample_time: float

    @property
    def highest(self) -> float:
        """The Nyquist frequency, rad/s; infinite for a continuous loop: nothing beyond it is a solution."""
        return math.pi / self.sample_time if self.sample_time > 0.0 else math.inf

    @property
    def own_frequency(self) -> float:
        """sqrt(Kp/J), rad/s."""
        return math.sqrt(self.entry.kp / self.inertia)

    def passage(self, omega: Floats) -> Complex:
        """Return motor torque over computed command: hold, delays, lag and actuator effects."""
        s = 1j * np.asarray(omega, dtype=float)
        way = np.exp(-s * self.delay) / (1.0 + s * self.entry.actuator_lag)
        if self.drive is not None:
            way = way * _at(self.drive, s, 0) / _at(self.plant, s, 0)
        if self.sample_time > 0.0:
            step = s * self.sample_time
            way = way * np.exp(-step * self.entry.delay_samples) * -np.expm1(-step) / step
        return np.asarray(way)

    def estimator(self, omega: Floats) -> Complex:
        """Return estimated over true velocity."""
        s, entry = 1j * np.asarray(omega, dtype=float), self.entry
        if self.sample_time == 0.0:
            return np.asarray(1.0 / (1.0 + s * entry.velocity_filter))
        back = np.exp(-s * self.sample_time)
        value = np.ones_like(s) if entry.velocity == "true" else (1.0 - back) / (s * self.sample_time)
        if entry.velocity_filter > 0.0:
            gain = -math.expm1(-self.sample_time / entry.velocity_filter)
            value = value * gain / (1.0 - (1.0 - gain) * back)
        return np.asarray(value)

    def feedback(self, omega: Floats) -> Complex:
        """Return the torque with which the linear controller opposes a velocity, N m s/rad."""
        s = 1j * np.asarray(omega, dtype=float)
        law = controller(self.entry, self.entry.kp, self.kv, self.sample_time)
        point = np.exp(s * self.sample_time) if self.sample_time > 0.0 else s
        state = np.linalg.solve(
            point[..., None, None] * np.eye(len(law.a)) - law.a,
            np.broadcast_to(law.b.astype(complex), (*point.shape, *law.b.shape)),
        )
        gain = (law.c @ state + law.d)[..., 0, :]
        return np.asarray(-self.passage(omega) * (gain[..., 0] / s + gain[..., 1]))

    def response(self, omega: Floats) -> Complex:
        """Return W: velocity over the torque that drives the motor, with the linear controller closed, rad/(N m s)."""
        free = _at(self.plant, 1j * np.asarray(omega, dtype=float), 1)
        return np.asarray(free / (1.0 + free * self.feedback(omega)))


def linear_part(arm: Arm, loop: Loop, joint: str) -> LinearPart:
    """Return the linear part of a joint's loop, the other joints held in the pose in which the loop works.

    Raises
    ------
    InputError
        When the loop does not control the joint.
    StribeckError
        When no command keeps the arm steady in that pose.
    """
    entry = next((e for e in loop.joints if e.joint == joint), None)
    if entry is None:
        raise InputError("the loop does not control this joint", joint, "add a [[joints]] entry for it")
    n, j = arm.n, arm.names.index(joint)
    point = OperatingPoint(tuple(pose(arm, loop)), (0.0,) * n, tuple("free" if i == j else "clamped" for i in range(n)))
    commanded, at_motor = linearise(arm, point), linearise(arm, point, at_motor=True)
    same = commanded.system.nstates == at_motor.system.nstates and np.allclose(commanded.system.B, at_motor.system.B)
    drive = None if same else commanded.system
    kv = derivative_gain(entry, entry.kp, float(tuned_inertia(arm, loop)[j]))
    late, inertia = float(commanded.delays[0]), float(at_motor.inertia[0])
    return LinearPart(at_motor.system, drive, late, entry, kv, inertia, loop.sample_time)


def _at(system: ct.StateSpace, s: Complex, output: int) -> Complex:
    """Return a transfer from the only input to one output."""
    a, b, c = np.asarray(system.A), np.asarray(system.B), np.asarray(system.C)[[output]]
    solved = np.linalg.solve(
        s[..., None, None] * np.eye(len(a)) - a, np.broadcast_to(b.astype(complex), (*s.shape, *b.shape))
    )
    return np.asarray((c @ solved)[..., 0, 0])
