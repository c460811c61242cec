"""The control loop as a value: what stands in a loop file (``stribeck.loop/1``)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, Literal

from pydantic import ConfigDict, Field

from stribeck.arm.values import Finite, Name, NotNegative, Positive

Count = Annotated[int, Field(strict=True, ge=0, le=1000)]
Numbers = Annotated[tuple[Finite, ...], Field(max_length=100_000)]

_STRICT = ConfigDict(extra="forbid")


@dataclass(frozen=True)
class Compensation:
    """Friction compensation of one joint; its constants are the arm's, times ``ratio``.

    Attributes
    ----------
    kind : str
        ``none``, ``feedforward`` (reference velocity), ``feedback`` (measured velocity), ``adaptive`` (Canudas de Wit
        et al. 1991), ``robust`` (Southward et al. 1991) or ``dither``.
    ratio : float
        k, compensation over true friction.
    at_zero : str
        Sign that ``feedback`` and ``adaptive`` take friction to have at velocity zero: ``zero``, ``hold`` (the last
        one), ``error_sign``, or ``set_valued`` (the sign of the control torque, so that net friction is (1 - k) F).
    dead_band : float
        Velocity that counts as zero, rad/s.
    gain : tuple of 3 floats
        ``adaptive``: adaptation gains of C0, C1 and C2.
    slope, leakage : float
        ``adaptive``: weight of the error in the adaptation (1/s), and its sigma-modification.
    inner : float
        ``robust``: error within which it is off, of a continuous controller 1e-9 at least; ``adaptive``: within which
        adaptation stops, rad.
    amplitude, frequency : float
        ``dither``: N m and Hz.
    """

    __pydantic_config__ = _STRICT

    kind: Literal["none", "feedforward", "feedback", "adaptive", "robust", "dither"] = "none"
    ratio: NotNegative = 1.0
    at_zero: Literal["zero", "hold", "error_sign", "set_valued"] = "zero"
    dead_band: NotNegative = 0.0
    gain: tuple[NotNegative, NotNegative, NotNegative] = (100.0, 100.0, 10.0)
    slope: NotNegative = 1.0
    leakage: NotNegative = 0.0
    inner: NotNegative = 0.0
    amplitude: NotNegative = 0.0
    frequency: NotNegative = 0.0


@dataclass(frozen=True)
class Reference:
    """What one joint shall follow, from where it starts.

    Attributes
    ----------
    kind : str
        ``ramp``, ``regulate``, ``sine``, ``steps`` or ``file``.
    velocity : float
        ``ramp``: rad/s.
    initial_error : float
        ``regulate`` alone: reference less position at the start, rad.
    amplitude, frequency, phase : float
        ``sine``: rad, Hz, rad; the joint starts on the reference.
    times, values : tuple of floats
        ``steps``: instants (s) and the positions from then on (rad); ``start`` before the first.
    file : str
        ``file``: a run whose reference positions, or else positions, and their slopes are followed; beside the loop
        file, and mended as all runs are (:func:`stribeck.run.reading.as_read`). Before its first row and behind its
        last the reference stands.
    """

    __pydantic_config__ = _STRICT

    kind: Literal["ramp", "regulate", "sine", "steps", "file"]
    velocity: Finite = 0.0
    initial_error: Finite = 0.0
    amplitude: Finite = 0.0
    frequency: NotNegative = 0.0
    phase: Finite = 0.0
    times: Numbers = ()
    values: Numbers = ()
    file: str = ""

    @property
    def error_at_start(self) -> float:
        """Reference less position at the start, rad: of one that regulates; on all others the joint starts."""
        return self.initial_error if self.kind == "regulate" else 0.0

    def within(self, duration: float) -> Reference:
        """Return the reference without the steps that a duration (s) does not reach."""
        if self.kind != "steps":
            return self
        count = sum(time < duration for time in self.times)
        return replace(self, times=self.times[:count], values=self.values[:count])


@dataclass(frozen=True)
class JointLoop:
    """The controller of one joint: PID on the measured position, and friction compensation.

    Attributes
    ----------
    joint : str
        Its name in the arm file.
    kp, ki : float
        N m/rad, N m/(rad s).
    reference : Reference
    kv : float or None
        N m s/rad; None is critical damping, 2 sqrt(kp J), J the joint's inertia with the others held where the loop
        starts.
    inertia : float
        Feedforward of the reference's acceleration, kg m^2.
    velocity : str
        ``true`` or ``finite_difference`` (whose limit for a continuous controller is ``true``; sampled, steps below
        1e-12 rad count as none, also those that a filtered velocity is worth).
    velocity_filter, actuator_lag : float
        First order, s.
    delay_samples : int
        Whole samples from measurement to torque.
    encoder_resolution, encoder_noise : float
        rad; the noise is a standard deviation.
    compensation : Compensation
    start : float
        Position at which the joint's reference begins, rad.
    """

    __pydantic_config__ = _STRICT

    joint: Name
    kp: Positive
    reference: Reference
    kv: NotNegative | None = None
    ki: NotNegative = 0.0
    inertia: NotNegative = 0.0
    velocity: Literal["finite_difference", "true"] = "finite_difference"
    velocity_filter: NotNegative = 0.0
    delay_samples: Count = 0
    actuator_lag: NotNegative = 0.0
    encoder_resolution: NotNegative = 0.0
    encoder_noise: NotNegative = 0.0
    compensation: Compensation = field(default_factory=Compensation)
    start: Finite = 0.0


@dataclass(frozen=True)
class Loop:
    """A control loop around an arm.

    Attributes
    ----------
    sample_time : float
        s; 0 is a continuous controller.
    duration : float
        s.
    joints : tuple of JointLoop
        The controlled joints; the others are held still (clamped).
    clamp : mapping
        Position of each clamped joint, rad; 0 where not given.
    record_step : float
        Time between the rows of a continuous controller's record, s.
    seed : int
        Of the encoder noise.
    """

    __pydantic_config__ = _STRICT

    sample_time: NotNegative
    duration: Positive
    joints: Annotated[tuple[JointLoop, ...], Field(min_length=1)]
    clamp: Mapping[str, Finite] = field(default_factory=dict)
    record_step: Positive = 1e-3
    seed: Annotated[int, Field(strict=True, ge=0)] = 0

    @property
    def step(self) -> float:
        """Time between rows of the record, s."""
        return self.sample_time if self.sample_time > 0.0 else self.record_step
