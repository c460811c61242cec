"""The laboratory: moves the plant under a sampled controller of its own and writes down what it sees."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stribeck.arm import Arm
from stribeck.errors import StribeckError
from stribeck.run import Run
from stribeck.withheld.injections import Injection, Setup, assemble
from stribeck.withheld.motions import Motion
from stribeck.withheld.plant import STEP, Array, Drive, Plant, Trace, rigid_torque, simulate

SETTLE = 0.5  # s, the controller holds the start before the record begins
TAIL = 0.1  # s, and the end after it has ended
DRIVE_WINDOW = 5e-3  # s, over which the drive takes its velocity
BRAKE = 1e6  # N m, that a brake holds against
PAUSE = 30.0  # s between two runs, in which a warm joint cools


@dataclass(frozen=True)
class Gains:
    """The laboratory's controller, one value a joint: PID on position, velocity from filtered differences.

    Attributes
    ----------
    kp, kd, ki : tuple of float
        N m/rad, N m s/rad, N m/(rad s).
    velocity_filter : float
        Time constant, s.
    forward : str
        What the controller's own model adds from the reference: ``"none"``, ``"gravity"`` or ``"inertial"``.
    """

    kp: tuple[float, ...]
    kd: tuple[float, ...]
    ki: tuple[float, ...]
    velocity_filter: float = 0.005
    forward: str = "gravity"


def default_gains(
    arm: Arm, bandwidth: float = 3.0, damping: float = 0.8, integral: float = 0.3, forward: str = "gravity"
) -> Gains:
    """Return gains for a natural frequency with the inertia of the stretched arm.

    Parameters
    ----------
    arm : Arm
    bandwidth : float
        Natural frequency, Hz.
    damping : float
        Damping ratio.
    integral : float
        Ki over the product of Kp and the natural frequency (rad/s).
    forward : str
        As of `Gains`.
    """
    n = arm.n
    zero, unit = np.zeros((n, n)), np.eye(n)
    inertia = np.diag(rigid_torque(arm, zero, zero, unit) - rigid_torque(arm, zero, zero, zero))
    omega = 2.0 * np.pi * bandwidth
    kp = inertia * omega**2
    return Gains(
        tuple(kp), tuple(2.0 * damping * omega * inertia), tuple(integral * omega * kp), forward=forward
    )  # fmt: skip


def record(
    arm: Arm,
    effects: Iterable[Injection],
    motions: Sequence[Motion],
    *,
    rate: float,
    resolution: float | None = None,
    encoder_bits: int | None = None,
    noise: float | Sequence[float] = 0.0,
    gains: Gains | None = None,
    model: Arm | None = None,
    channels: Sequence[str] = (),
    torque_noise: float = 0.0,
    seed: int = 0,
    step: float = STEP,
) -> tuple[Run, ...]:
    """Record one run a motion; the same arguments give the same numbers.

    Parameters
    ----------
    arm : Arm
        The true arm.
    effects : iterable of Injection
        Hidden effects (name, joint, parameters).
    motions : sequence of Motion
        What the controller is asked to do, in this order; warm-up and wear carry over from run to run.
    rate : float
        Samples a second, Hz; the command is held in between.
    resolution, encoder_bits : float or None, int or None
        Encoder count, rad, or its bits a turn; the arm's own resolution where both are None.
    noise : float or sequence of float
        Standard deviation of the encoder's noise before rounding, of each joint where there are several, rad.
    gains : Gains or None
        The controller; `default_gains` of `model` where None.
    model : Arm or None
        The controller's own, wrong model; the true arm where None.
    channels : sequence of str
        Further channels: ``dq`` (the drive's velocity), ``q_ref``, ``dq_ref``, ``tau_meas`` (torque of the rotor).
    torque_noise : float
        Standard deviation of the noise of ``tau_meas``, N m.
    seed : int
        Of everything random.
    step : float
        Longest internal step of the plant, s.

    Raises
    ------
    StribeckError
        For an unknown effect, joint, parameter or channel, or where the motion diverges.
    """
    unknown = set(channels) - {"dq", "q_ref", "dq_ref", "tau_meas"}
    if unknown:
        raise StribeckError(
            "the recorder has no such channel", ", ".join(sorted(unknown)), "use dq, q_ref, dq_ref, tau_meas"
        )
    count = 2.0 * np.pi / 2**encoder_bits if encoder_bits else resolution
    setup = assemble(arm if count is None else _with_encoder(arm, count), effects)
    gains = gains or default_gains(model or arm)
    plant = _controlled(setup.plant, gains)
    lab = Laboratory(
        setup, plant, model or arm, gains.forward, rate, np.asarray(noise), torque_noise, tuple(channels), seed, step
    )  # fmt: skip
    runs, warmth = [], np.zeros(arm.n)
    for i, motion in enumerate(motions):
        run, warmth = lab.run(motion, warmth, i)
        warmth = _after_pause(plant, warmth)
        runs.append(run)
    return tuple(runs)


@dataclass(frozen=True)
class Laboratory:
    """One arm on its stand, ready to record."""

    setup: Setup
    plant: Plant
    model: Arm
    forward: str
    rate: float
    noise: Array
    torque_noise: float
    channels: tuple[str, ...]
    seed: int
    step: float

    def run(self, motion: Motion, warmth: Array, i: int) -> tuple[Run, Array]:
        """Return the record of `motion` as run number `i`, and the state of warm-up or wear (n,) after it."""
        period, n, held = 1.0 / self.rate, self.plant.n, list(motion.held)
        first = math.ceil(SETTLE * self.rate)
        count = round(motion.duration * self.rate) + 1
        t: Array = (np.arange(first + count + math.ceil(TAIL * self.rate)) - first) * np.float64(period)
        q, dq, ddq = motion.sample(t)
        forward = self._forward(q, dq, ddq)
        if motion.torque is not None:
            moving = (t >= 0.0) & (t <= motion.duration)
            forward = forward + np.stack([np.where(moving, curve(t), 0.0) for curve in motion.torque], axis=1)
        forward[:, held] = 0.0
        fine = max(1, round(period / 1e-3))
        push, factor = self._disturb(len(t) * fine + 1, period / fine, i)
        start = np.stack([q[0], np.zeros(n)], axis=1)
        noise = self.noise * self._stream(i, 0).standard_normal((len(t), n))
        substeps = math.ceil(period / self.step - 1e-9)
        drive = Drive(period, np.stack([q, dq], axis=2), forward, noise, push, factor, start, warmth, substeps)
        trace = simulate(_braked(self.plant, held), drive)
        rows = slice(first, first + count)
        seen = {"q_ref": q, "dq_ref": dq, "dq": self._velocity(trace, i), "tau_meas": self._torque(trace, i)}
        run = Run(f"run_{i:02d}", t[rows] - t[first], trace.q[rows], trace.tau[rows])
        for channel in self.channels:
            run = replace(run, **{channel: seen[channel][rows]})  # type: ignore[arg-type]
        return run, trace.warmth

    def _velocity(self, trace: Trace, i: int) -> Array:
        """Return what a drive tells of its velocity: differences of encoder counts over a few milliseconds."""
        count = np.array([self.plant.get(k, "resolution") for k in range(self.plant.n)])
        size = 2.0 * np.hypot(self.noise, count / math.sqrt(12.0)) / DRIVE_WINDOW
        return np.asarray(trace.dq + size * self._stream(i, 2).standard_normal(trace.dq.shape))

    def _torque(self, trace: Trace, i: int) -> Array:
        return np.asarray(trace.torque + self.torque_noise * self._stream(i, 1).standard_normal(trace.torque.shape))

    def _stream(self, run: int, use: int) -> np.random.Generator:
        """Return the random numbers of one use in one run: an effect leaves the noise of the encoder as it was."""
        return np.random.default_rng([self.seed, run, use])

    def _forward(self, q: Array, dq: Array, ddq: Array) -> Array:
        if self.forward == "none":
            return np.zeros_like(q)
        if self.forward == "gravity":
            return rigid_torque(self.model, q, 0.0 * q, 0.0 * q)
        return rigid_torque(self.model, q, dq, ddq)

    def _disturb(self, points: int, step: float, i: int) -> tuple[Array, Array]:
        push, factor = np.zeros((points, self.plant.n)), np.ones((points, self.plant.n))
        for number, (k, disturbance) in enumerate(self.setup.disturbances):
            signal = disturbance.signal(np.arange(points) * np.float64(step), self._stream(i, 10 + number))
            if disturbance.kind == "torque":
                push[:, k] += signal
            else:
                factor[:, k] *= signal
        return push, factor


def _after_pause(plant: Plant, warmth: Array) -> Array:
    """Return what is left (n,) of the warm-up, or of the wear, of which newness is exp(-wear)."""
    left = []
    for k, state in enumerate(warmth):
        if plant.get(k, "wear_work"):
            newness = math.exp(-state)
            left.append(-math.log(newness + plant.get(k, "wear_lost") * (1.0 - newness)))
        else:
            left.append(state * math.exp(-PAUSE / max(plant.get(k, "warm_time"), 1e-9)))
    return np.array(left)


def _with_encoder(arm: Arm, resolution: float) -> Arm:
    return replace(arm, joints=tuple(replace(joint, encoder_resolution=resolution) for joint in arm.joints))


def _braked(plant: Plant, joints: Sequence[int]) -> Plant:
    """Return the plant with brakes on: friction beyond all torque, on no bristles that would give way to it."""
    for k in joints:
        plant = plant.with_joint(k, kp=0.0, kd=0.0, ki=0.0, f_C0=BRAKE, b_C0=BRAKE, bristle_stiffness=0.0)
    return plant


def _controlled(plant: Plant, gains: Gains) -> Plant:
    for k in range(plant.n):
        plant = plant.with_joint(
            k,
            kp=gains.kp[k],
            kd=gains.kd[k],
            ki=gains.ki[k],
            control_filter=gains.velocity_filter,
        )
    return plant
