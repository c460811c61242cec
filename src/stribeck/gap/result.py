"""What a diagnosis says, as plain values; :mod:`stribeck.gap.answer.files` writes them, the report draws them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from stribeck.arm import Arm
from stribeck.run import Run

VERDICTS = ("no_gap", "explained", "partly_explained", "unexplained")


@dataclass(frozen=True)
class Estimate:
    """A value with its 95 % interval and unit."""

    value: float
    low: float
    high: float
    unit: str = ""


@dataclass(frozen=True)
class Stage:
    """The gap left at one stage, per joint name: ``torque`` in N m rms, ``motion`` in rad rms over the horizon.

    ``stage`` is ``as_given``, ``retuned``, the name of an effect that was added, or ``noise_floor``.
    A joint is missing from ``motion`` where no window could be simulated.
    """

    stage: str
    torque: Mapping[str, float]
    motion: Mapping[str, float]


@dataclass(frozen=True)
class Place:
    """A share of what re-tuning leaves beyond noise: one joint, one stage of the path, one region.

    Of the squares, each joint's by its noise floor.
    ``channels`` are all stages in which it may be, ``channel`` first: those of the effects that the data cannot tell
    from the one that takes the share.
    """

    joint: str
    channel: str
    region: str
    share: Estimate
    channels: tuple[str, ...] = ()


@dataclass(frozen=True)
class Region:
    """The residual of one joint in one region, for the map of where.

    ``share`` is of that joint's squared residual beyond noise (by frequency: of all of it), ``time_share`` of the time,
    ``rms`` in N m before and ``rms_corrected`` after the named effects; ``family`` groups the regions that partition
    the same samples.
    """

    joint: str
    family: str
    region: str
    share: Estimate
    time_share: float
    rms: float
    rms_corrected: float


@dataclass(frozen=True)
class Recording:
    """What one joint's torque leaves in one recording, N m rms: re-tuned, with the named effects, and its noise.

    ``held_out`` is whether the recording, or the part of it, judged and was not fitted.
    """

    run: str
    held_out: bool
    joint: str
    retuned: float
    corrected: float
    noise: float


@dataclass(frozen=True)
class Cause:
    """One candidate explanation; ``effect`` may be ``none`` or ``unknown``.

    ``probability`` sums to 1 over the causes: where several effects are named together they share it by how
    many times each makes less of what is left, in logarithms; those that the records show by themselves close nothing
    and take even parts. ``presence`` is the probability that this effect is there at all, beside whatever else is.
    ``parameters`` is joint -> parameter -> Estimate; ``closes`` the part of the closable gap that it closes;
    ``law`` is joint -> law, where the effect is a family with several. ``alike`` is joint -> those of ``equivalent``
    that the data cannot tell from it there.
    ``anywhere``: it is at one of the joints at least, and the data cannot tell at which.
    """

    effect: str
    probability: float
    joints: tuple[str, ...] = ()
    equivalent: tuple[str, ...] = ()
    parameters: Mapping[str, Mapping[str, Estimate]] = field(default_factory=dict)
    closes: Estimate | None = None
    presence: float | None = None
    law: Mapping[str, str] = field(default_factory=dict)
    alike: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    anywhere: bool = False


@dataclass(frozen=True)
class Candidate:
    """A row of the ranking at one step of the search.

    ``joint`` names all joints of a law that holds at several, with commas between; ``gain`` is the part of the
    squared residual that the candidate removes on held-out data, what is left multiplied over the joints; ``t`` the
    block-robust t value of its gain; ``status`` the solver's, or ``screened out``.
    """

    step: int
    effect: str
    joint: str
    gain: Estimate
    t: float
    status: str
    chosen: bool = False


@dataclass(frozen=True)
class Tuned:
    """A value of the arm file before and after re-tuning; ``at_limit`` where the data push it to three deviations.

    Those of its effects have a ``tolerance`` of infinity: ``moved`` is whether one has left its nominal value far.
    """

    key: str
    unit: str
    nominal: float
    tolerance: float
    tuned: Estimate
    at_limit: bool = False
    identified: bool = True
    moved: bool = False


@dataclass(frozen=True)
class Delivered:
    """The measured torque of one joint beside the commanded one, where the recordings hold both.

    ``gain``, ``offset`` and ``delay`` lead from the command to it, ``left`` is what they leave, rms in the unit of
    torque. ``share`` is the least part of the gap that re-tuning leaves which lies before the measurement: gone where
    the measured torque stands in for the command, but for what any gain and offset of that close; none where it is the
    command, to the noise (None: there is no gap, or the measured torque does not follow the command).
    """

    joint: str
    gain: Estimate
    offset: Estimate
    delay: Estimate
    left: float
    share: Estimate | None = None


@dataclass(frozen=True)
class RandomTorque:
    """Torque at a joint that knows nothing of the motion and counts as noise: ``rms`` in ``unit``, ``bandwidth`` Hz."""

    joint: str
    rms: float
    bandwidth: float
    unit: str = "N m"


@dataclass(frozen=True)
class Trace:
    """Held-out signals of one run for the figures; arrays (M, n) over ``time`` (M,), N m, rad, rad/s.

    ``measured`` is the filtered command; ``nominal``, ``retuned``, ``corrected`` the torque that each model
    needs along the recorded motion. The time is that since the recording began, s, also where a part is held out.
    """

    run: str
    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    measured: np.ndarray
    nominal: np.ndarray
    retuned: np.ndarray
    corrected: np.ndarray


@dataclass(frozen=True)
class Diagnosis:
    """The whole answer.

    ``closed`` is the part of the closable gap that the named effects close on held-out runs (None: nothing closable),
    ``before_measurement`` the part of it that lies before the measured torque, where runs hold that, all joints
    together. ``tuned`` are the arm file's values as re-tuned, ``corrected`` the same beside the effects that the torque
    names: those of the arm that is delivered, none where nothing is named. ``models`` holds the arms ``as_given``,
    ``retuned`` and ``corrected``. ``next_reference`` is what a controller is to follow in the ``next_experiment``; its
    torque is what the best model needs for that.
    """

    arm: str
    joints: tuple[str, ...]
    fit_runs: tuple[str, ...]
    held_out_runs: tuple[str, ...]
    verdict: str
    named: tuple[str, ...]
    horizon: float
    stages: tuple[Stage, ...]
    closed: Estimate | None
    where: tuple[Place, ...]
    regions: tuple[Region, ...]
    causes: tuple[Cause, ...]
    candidates: tuple[Candidate, ...]
    tuned: tuple[Tuned, ...]
    traces: tuple[Trace, ...]
    models: Mapping[str, Arm]
    notes: tuple[str, ...]
    warnings: tuple[str, ...]
    next_experiment: Mapping[str, object] | None = None
    next_reference: Run | None = None
    delivered: tuple[Delivered, ...] = ()
    recordings: tuple[Recording, ...] = ()
    before_measurement: Estimate | None = None
    corrected: tuple[Tuned, ...] = ()
    random: tuple[RandomTorque, ...] = ()
    settings: Mapping[str, float | str] = field(default_factory=dict)
