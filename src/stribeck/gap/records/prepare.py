"""From files to conditioned runs: uniform time, one analysis cutoff, fit and held-out parts, typical scales."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import casadi as ca
import numpy as np

from stribeck.arm import Arm, doubtful_values
from stribeck.errors import InputError
from stribeck.gap.records.passed import Passed
from stribeck.gap.records.rests import without_long_rests
from stribeck.gap.records.rhythm import rhythm
from stribeck.gap.records.sequence import distance_gone, in_sequence, order
from stribeck.gap.records.split import split
from stribeck.gap.records.spread import Noise
from stribeck.gap.records.standing import driven_in_vain, seen_on_one_side, standing
from stribeck.gap.records.unsaid import with_unsaid
from stribeck.grid import uniform
from stribeck.identify.braked import DRIVEN
from stribeck.identify.commanded import doubtful_torques
from stribeck.identify.conditioning import Conditioned, condition, shaken
from stribeck.identify.cutoff import cutoff_frequency
from stribeck.identify.inertia import MovedInertia
from stribeck.identify.noise import doubtful_resolutions, encoder_noise
from stribeck.identify.stretches import between_gaps, shortened
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath
from stribeck.model.rigid_body import inverse_dynamics
from stribeck.model.scale import Scale
from stribeck.run import Run
from stribeck.run.checks import FEWEST_ROWS
from stribeck.run.turns import in_one_turn

LOUD_SEED = 1
PUSH = 0.01  # of the typical torque: less than stiction holds would be lost at rest at one arm and not at another


@dataclass(frozen=True)
class Prepared:
    """Runs ready for the search.

    ``fit`` and ``held`` are conditioned runs; ``scales`` typical magnitudes per joint; ``cutoff`` in Hz; ``noise`` that
    of every row of the residual, once a model is there to tell, and ``reference`` what noise adds to the re-tuned
    model's; ``arm`` has tolerances for what its file, as ``stated``, says nothing of.
    """

    arm: Arm
    fit: tuple[Conditioned, ...]
    held: tuple[Conditioned, ...]
    scales: tuple[Scale, ...]
    cutoff: float
    notes: tuple[str, ...]
    warnings: tuple[str, ...]
    noise: Noise | None = None
    stated: Arm | None = None
    reference: Passed | None = None

    @property
    def push(self) -> np.ndarray:
        """A small torque (n,) at each joint, N m."""
        return PUSH * np.array([scale.torque for scale in self.scales])

    @cached_property
    def moved(self) -> tuple[Conditioned, ...]:
        """All runs, fitted ones first, with the encoder's noise once more."""
        rng = np.random.default_rng(LOUD_SEED)
        every = (*self.fit, *self.held)
        return tuple(shaken(self.arm, run, self.cutoff, rng.standard_normal(run.run.q.shape)) for run in every)

    @cached_property
    def pushed(self) -> tuple[Conditioned, ...]:
        """Held-out runs with white noise in the commands: ``push``, N m rms, behind the analysis filter."""
        rng = np.random.default_rng(LOUD_SEED + 1)
        white = [rng.standard_normal(run.command.shape) / np.sqrt(np.sum(run.taps**2)) for run in self.held]
        return tuple(replace(run, command=run.command + self.push * w) for run, w in zip(self.held, white, strict=True))

    def path(self, placed: Sequence[Placed]) -> SignalPath:
        """Return the path of the arm with effects, for a fit: their places are looked for where the joints move."""
        return SignalPath(self.arm, placed, [scale.middle for scale in self.scales])

    @property
    def file_arm(self) -> Arm:
        """The arm as its file has it: ``arm`` has more tolerances, and may have other lengths."""
        return self.stated or self.arm

    def as_stated(self, arm: Arm) -> Arm:
        """Return an arm with no other tolerances than those of the arm file."""
        if self.stated is None:
            return arm
        pairs = zip(arm.joints, self.stated.joints, strict=True)
        return replace(arm, joints=tuple(replace(joint, tolerance=said.tolerance) for joint, said in pairs))


def prepare(arm: Arm, runs: Sequence[Run], held_out: Sequence[Run] = (), fitted: Collection[str] = ()) -> Prepared:
    """Condition runs for a diagnosis.

    Parameters
    ----------
    arm : Arm
    runs : sequence of Run
        Fitted; some of them are kept back where ``held_out`` is empty. In which order they are given does not matter
        where their times or names tell one.
    held_out : sequence of Run
        Judged, never fitted.
    fitted : collection of str
        Names of runs that are not kept back, as far as any need not be.

    Raises
    ------
    InputError
        When a run, or the part of one that is kept back, is too short.
    """
    notes: list[str] = []
    even, kept_back = _even(runs, held_out, notes)
    whole, recorded = [*even, *kept_back], [*runs, *held_out]
    noise = encoder_noise(arm, whole, recorded)
    moving, judged = ([without_long_rests(run, noise, notes) for run in runs] for runs in (even, kept_back))
    fit, held = (moving, judged) if held_out else split(moving, notes, fitted)
    fit, held = (shortened(between_gaps(part, notes), notes) for part in (fit, held))
    every = [*fit, *held]
    inertia = moved_inertia(arm, every)
    for run in every:
        _check_length(run.name, len(run.t), FEWEST_ROWS)
    cutoff = cutoff_frequency(arm, every, inertia, noise)
    notes.append(f"analysed up to {cutoff:.3g} Hz")
    conditioned = in_sequence([condition(arm, run, cutoff, noise, thin=True) for run in every], whole)
    learnt, kept = (_filtered(group, cutoff) for group in (conditioned[: len(fit)], conditioned[len(fit) :]))
    conditioned = (*learnt, *kept)
    notes += _held(arm, conditioned)
    doubts = dict.fromkeys(f"{run.name}: {text}" for run in every for text in run.warnings)
    unseen = (*driven_in_vain(arm, conditioned), *seen_on_one_side(arm, learnt, kept))
    doubtful = (*doubtful_resolutions(arm, whole, recorded), *doubtful_torques(arm, every, noise))
    warnings = (*doubtful_values(arm), *doubts, *unseen, *doubtful)
    gone = sum(distance_gone(run.q, run.sample_time) for run in whole)
    scales = typical(arm, learnt, inertia, np.asarray(gone))
    retunable, said = with_unsaid(arm, scales, standing(learnt)), _together(notes)
    return Prepared(retunable, learnt, kept, scales, cutoff, said, warnings, stated=arm)


def _even(runs: Sequence[Run], held_out: Sequence[Run], notes: list[str]) -> tuple[list[Run], list[Run]]:
    """Return both kinds of runs in order, on uniform clocks and in the same turn of each joint."""
    ordered = [group[i] for group in (runs, held_out) for i in order(group)]
    for run in ordered:
        _check_length(run.name, len(run.t), FEWEST_ROWS)
    out = []
    since = min(float(run.t[0]) for run in ordered)
    for run in in_one_turn(ordered, notes):
        even, said = uniform(run, since)
        notes.extend(said)
        out.append(even)
    return out[: len(runs)], out[len(runs) :]


def _check_length(name: str, samples: int, least: int) -> None:
    if samples < least:
        raise InputError(f"{name}: too short to be analysed", f"{samples} samples", "leave it out")


def _filtered(runs: Sequence[Conditioned], cutoff: float) -> tuple[Conditioned, ...]:
    """Return runs without stretches that are too short for the filter, of those that longer ones are left of."""
    long = {run.name for run in runs if len(run.time) >= len(run.taps)}
    for run in runs:
        if run.name not in long:
            _check_filtered(run, cutoff)
    return tuple(run for run in runs if len(run.time) >= len(run.taps))


def _check_filtered(one: Conditioned, cutoff: float) -> None:
    if len(one.time) < len(one.taps):
        seconds = len(one.run.t) * one.run.sample_time
        least = seconds * len(one.taps) / len(one.time)
        found = f"{len(one.run.t)} samples, {seconds:.3g} s, where the filter for {cutoff:.3g} Hz takes {least:.3g} s"
        do = "leave it out, or check the units of q and tau: noise in q beside the torque sets that frequency"
        raise InputError(f"{one.name}: too short to be analysed", found, do)


def _held(arm: Arm, runs: Sequence[Conditioned]) -> list[str]:
    """Return a note on each recording, of which runs may be parts, with joints that it neither moves nor drives."""
    said = []
    for name in dict.fromkeys(run.name for run in runs):
        held = np.all([run.braked for run in runs if run.name == name], axis=0)
        if held.any():
            which = ", ".join(arm.names[j] for j in np.flatnonzero(held))
            said.append(f"{name}: {which} neither moves nor is driven: taken as held, by a brake or not")
    return said


def _together(notes: Sequence[str]) -> tuple[str, ...]:
    """Return the notes on runs, those that say the same of several made one."""
    runs: dict[str, list[str]] = {}
    for note in notes:
        name, colon, text = note.partition(": ")
        name, text = (name, text) if colon else ("", note)
        runs.setdefault(text, []).append(name)
    return tuple(f"{', '.join(names)}: {text}" if names[0] else text for text, names in runs.items())


def moved_inertia(arm: Arm, runs: Sequence[Run]) -> np.ndarray:
    """Return the mean inertia (n,) that each joint moves in the poses of the runs, kg m^2."""
    inertia = MovedInertia(SignalPath(arm))
    poses = np.concatenate([run.q[:: max(1, len(run.q) // 50)] for run in runs])
    return np.asarray(inertia(poses, values_of(inertia.path.entries)).mean(axis=0))


def needed_torque(arm: Arm, runs: Sequence[Conditioned]) -> np.ndarray:
    """Return the torque (n,) that the nominal arm needs at each joint for the motion of the runs, N m rms."""
    path = SignalPath(arm)
    motion = [ca.SX.sym(name, arm.n) for name in ("position", "velocity", "acceleration")]
    q, dq, ddq = (ca.vertsplit(values) for values in motion)
    torque = inverse_dynamics(path.body, q, dq, ddq, prismatic=path.prismatic)
    turning = [torque[j] + path.rotor(j) * ddq[j] for j in range(arm.n)]
    function = ca.Function("needed", [*motion, path.p], [ca.vertcat(*turning)])
    names = ("position", "velocity", "acceleration")
    rows = [np.concatenate([getattr(run, name)[run.analysis_index] for run in runs]) for name in names]
    constants = [joint.friction for joint in arm.joints]
    level, viscous = np.array([f.C0 for f in constants]), np.array([f.C2 for f in constants])
    friction = level * np.sign(rows[1]) + viscous * rows[1]
    values = function(*[row.T for row in rows], values_of(path.entries)).full().T + friction
    return np.asarray(np.sqrt(np.mean(values**2, axis=0)))


def typical(arm: Arm, runs: Sequence[Conditioned], inertia: np.ndarray, gone: np.ndarray) -> tuple[Scale, ...]:
    """Return the typical magnitudes of each joint in conditioned runs, of joints that have ``gone`` (n,) so far."""

    def rms(name: str, j: int) -> float:
        return float(np.sqrt(np.mean(np.concatenate([getattr(run, name)[:, j] for run in runs]) ** 2)))

    def travel(j: int) -> float:
        return max(float(np.ptp(run.position[:, j])) for run in runs)

    needed = needed_torque(arm, runs)
    asked = [rms("command", j) for j in range(arm.n)]
    driven = [torque > DRIVEN * joint.friction.C0 for torque, joint in zip(asked, arm.joints, strict=True)]
    return tuple(
        Scale(
            torque=(asked[j] if driven[j] else float(needed[j])) + 1e-9,
            needed=float(needed[j]),
            driven=driven[j],
            friction=arm.joints[j].friction.C0,
            speed=rms("velocity", j) + 1e-6,
            travel=travel(j) + 1e-6,
            covered=float(np.ptp(np.concatenate([run.position[:, j] for run in runs]))),
            inertia=float(inertia[j]),
            sample_time=max(run.run.sample_time for run in runs),
            length=arm.joints[j].length,
            prismatic=arm.joints[j].kind == "prismatic",
            middle=float(np.median(np.concatenate([run.position[:, j] for run in runs]))),
            distance=float(gone[j]) + 1e-6,
            rotor=arm.joints[j].rotor_inertia,
            rhythm=rhythm(runs, j),
            gravity=arm.gravity,
        )
        for j in range(arm.n)
    )
