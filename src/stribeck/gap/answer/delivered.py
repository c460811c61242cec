"""What the drives delivered of the torque that they were asked for, where the records hold both.

A measured torque is a second place at which the signal path can be cut: what differs before it is the actuator's, what
does not balance behind it is not. How a torque was measured is not known (a current says nothing of cogging), so this
is told beside the causes and decides none of them. Nor is the scale: a drive that gives a constant part of its command
looks as a sensor does that reads a constant part of the torque, so what gain and offset close is not laid to the drive:
what is, is the least that it can be.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline
from scipy.optimize import minimize_scalar
from scipy.stats import t as student

from stribeck.arm import unit_at
from stribeck.effects.registry import effect_named
from stribeck.gap.answer.closing import closed_again, closure, with_interval
from stribeck.gap.answer.verdict import AT_FLOOR
from stribeck.gap.fitted.model import Model, retune
from stribeck.gap.records.blocks import block_of_rows, block_sums, resampled
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.result import Delivered, Estimate
from stribeck.identify.conditioning import Conditioned, condition
from stribeck.model.layout import Placed
from stribeck.run import Run

Floats = NDArray[np.float64]

LEAST = 1e-6  # of the larger torque's span: a smaller one is none, and tells nothing
EARLIEST, LATEST, TRIES = -0.05, 0.15, 81  # s; how many delays are tried before the best is refined
SCALE = "torque_gain", "torque_offset"


def delivered(
    prepared: Prepared, base: Model, floor: Floats, seed: int = 0
) -> tuple[tuple[Delivered, ...], Estimate | None]:
    """Compare measured with commanded torque, joint by joint; empty where a run lacks either.

    Beside it stands the part of the gap, all joints scaled by their floor, that lies before the measurement: what one
    drive does bends the values of other joints, too. None where there is no gap, or nothing that tells.

    Parameters
    ----------
    prepared : Prepared
    base : Model
        Re-tuned to the commanded torque.
    floor : array (n,)
        Noise floor of its residual, N m rms.
    seed : int
        Of the bootstrap.
    """
    runs = (*prepared.fit, *prepared.held)
    if not all(_has_it(run.run) for run in runs):
        return (), None
    measured = tuple(_measured(prepared, run, np.zeros(prepared.arm.n)) for run in runs)
    related = [relation(runs, measured, j) for j in range(prepared.arm.n)]
    rows = [
        Delivered(name, gain, replace(offset, unit=unit_at("N m", joint.kind)), delay, left, None)
        for name, joint, (gain, offset, delay, left) in zip(
            prepared.arm.names, prepared.arm.joints, related, strict=True
        )
    ]
    known = np.array([gain.low * gain.high > 0.0 for gain, *_ in related])
    gap = (base.rms() > AT_FLOOR * floor) & known
    if not gap.any():
        return tuple(rows), None
    instead = _stand_in(prepared, related, known)
    scale = _scale(base, known)
    asked, behind = (retune(one, floor, (*base.placed, *scale), known=base.fit) for one in (prepared, instead))
    held = base.held, asked.held, behind.held
    drawn = resampled(prepared.held, 400, seed)
    apart = _apart(prepared.held, instead.held)
    for j in np.flatnonzero(gap):
        if apart[j] > floor[j]:
            share = _share([part[:, j : j + 1] for part in held], floor[j : j + 1], *drawn)
        else:  # what is gone there was another drive's
            rms = base.rms()[j]
            most = (2.0 * rms - apart[j]) * apart[j] / (rms**2 - floor[j] ** 2)
            share = Estimate(0.0, 0.0, min(1.0, float(most)))
        rows[j] = replace(rows[j], share=share)
    return tuple(rows), _share(held, floor, *drawn)


def told_lacking(prepared: Prepared) -> list[str]:
    """Return a note on the runs that lack the measured torque that others hold: none is looked at then."""
    holds = {run.name: _has_it(run.run) for run in (*prepared.fit, *prepared.held)}
    if all(holds.values()) or not any(holds.values()):
        return []
    lacking = ", ".join(name for name, has in holds.items() if not has)
    return [f"{lacking}: no measured torque, or not all along: that of the other runs is not compared with commands"]


def _stand_in(
    prepared: Prepared, related: Sequence[tuple[Estimate, Estimate, Estimate, float]], known: NDArray[np.bool_]
) -> Prepared:
    """Return recordings whose commands are the measured torque, in units of the command, where it follows that."""
    scales = np.array([(gain.value, offset.value) for gain, offset, *_ in related]).T
    gain_of, offset_of = np.where(known, scales, [[1.0], [0.0]])
    late = np.nan_to_num([delay.value for _, _, delay, _ in related])
    # records may hold what was measured just before the new command: up to a sample is the logging's
    early = np.where(np.abs(late) <= max(run.run.sample_time for run in (*prepared.fit, *prepared.held)), late, 0.0)
    fit, held = (
        tuple(_measured(prepared, _in_units_of_command(run, gain_of, offset_of), early) for run in part)
        for part in (prepared.fit, prepared.held)
    )
    return replace(prepared, fit=fit, held=held)


def _scale(base: Model, known: NDArray[np.bool_]) -> tuple[Placed, ...]:
    """Return a gain and an offset of the drive at each joint whose measured torque is ``known`` to follow its command.

    Fitted to command and to measured torque alike, they are of neither.
    """
    there = {place.key for place in base.placed}
    placed = (Placed(effect_named(name), int(j)) for j in np.flatnonzero(known) for name in SCALE)
    return tuple(place for place in placed if place.key not in there)


def _apart(asked: Sequence[Conditioned], given: Sequence[Conditioned]) -> Floats:
    """Return how far (n,) the commands of some runs are from those of others, rms of what is looked at."""
    pairs = zip(asked, given, strict=True)
    rows = [np.stack([one.filtered(d) for d in (other.command - one.command).T], axis=1) for one, other in pairs]
    return np.asarray(np.sqrt(np.mean(np.concatenate(rows) ** 2, axis=0)))


def _share(held: Sequence[Floats], floor: Floats, block: NDArray[np.int_], draws: Floats) -> Estimate:
    """Return the part of a gap that is gone with the measured torque, but for what gain and offset alone close.

    Anything where the sensor surely adds more than is gone, or a scale surely closes more.

    Parameters
    ----------
    held : three arrays (M, k)
        Residual of the re-tuned model, that with gains and offsets, and that along the measured torque with them.
    floor : array (k,)
        Noise floor, N m rms.
    block : array (M,) of int
        The block of each row.
    draws : array (draws, blocks)
        Weights of the blocks, as of :func:`stribeck.gap.records.blocks.resampled`.
    """
    base, *others = held
    scaled, gone = (
        np.array([closure(base, other, floor), *closed_again(base, other, floor, block, draws)]) for other in others
    )
    more = gone - np.maximum(scaled, 0.0)  # a scale that misleads has closed nothing
    if with_interval(more[0], more[1:]).high < 0.0:
        return Estimate(0.0, 0.0, 1.0)
    value, *drawn = np.maximum(more, 0.0)
    return with_interval(value, drawn)


def as_commanded(run: Run, early: Floats | float = 0.0) -> Run:
    """Return a run whose command is its measured torque, taken earlier by as much (s, each joint's own).

    A command is held over the step that follows its sample; what was measured belongs to the instant. So it is moved
    by half a step.
    """
    assert run.tau_meas is not None
    curve = make_interp_spline(run.t, run.tau_meas, k=3)
    moved = np.broadcast_to(0.5 * run.sample_time + np.asarray(early), run.n)
    columns = [curve(np.clip(run.t + moved[j], run.t[0], run.t[-1]))[:, j] for j in range(run.n)]
    return replace(run, tau=np.stack(columns, axis=1))


def relation(
    commanded: Sequence[Conditioned], measured: Sequence[Conditioned], j: int
) -> tuple[Estimate, Estimate, Estimate, float]:
    """Return gain, offset and delay (s) from a joint's command to its measured torque, and what they leave, rms.

    Least squares on filtered torques; intervals by the sandwich over blocks of rows.
    """
    target = np.concatenate([run.filtered(run.command[:, j]) for run in measured])
    asked = np.concatenate([run.filtered(run.command[:, j]) for run in commanded])
    if min(np.ptp(target), np.ptp(asked)) <= LEAST * max(np.ptp(target), np.ptp(asked)):
        unknown = Estimate(np.nan, np.nan, np.nan)
        return unknown, unknown, replace(unknown, unit="s"), float(np.sqrt(np.mean(target**2)))
    curves = [make_interp_spline(run.time, run.command[:, j], k=3) for run in commanded]

    def design(delay: float, order: int = 0) -> Floats:
        late = [
            run.filtered(curve(np.clip(run.time - delay, run.time[0], run.time[-1]), order))
            for run, curve in zip(commanded, curves, strict=True)
        ]
        return np.stack([np.concatenate(late), np.ones(len(target))], axis=1)

    def misfit(delay: float) -> float:
        return float(np.sum((target - _projected(design(delay), target)) ** 2))

    tried = np.linspace(EARLIEST, LATEST, TRIES)
    near = float(tried[int(np.argmin([misfit(delay) for delay in tried]))])
    step = float(tried[1] - tried[0])
    delay = float(minimize_scalar(misfit, bounds=(near - step, near + step), method="bounded").x)
    columns = design(delay)
    (gain, offset), *_ = np.linalg.lstsq(columns, target)
    rest = target - columns @ np.array([gain, offset])
    slope = -gain * design(delay, 1)[:, :1]
    jacobian = np.concatenate([columns, slope], axis=1)
    half = _half_width(jacobian, rest, block_of_rows(commanded))
    values = zip((gain, offset, delay), half, ("", "", "s"), strict=True)
    first, second, third = (Estimate(float(v), float(v - h), float(v + h), unit) for v, h, unit in values)
    return first, second, third, float(np.sqrt(np.mean(rest**2)))


def _projected(columns: Floats, target: Floats) -> Floats:
    return np.asarray(columns @ np.linalg.lstsq(columns, target)[0])


def _half_width(jacobian: Floats, rest: Floats, block: NDArray[np.int_]) -> Floats:
    """Return the half widths of 95 % intervals, blocks as units."""
    scores = block_sums(jacobian * rest[:, None], block)
    count, free = len(scores), jacobian.shape[1]
    bread = np.linalg.pinv(jacobian.T @ jacobian)
    spare = max(count - free, 1)
    covariance = bread @ scores.T @ scores @ bread * (count / spare)
    return np.asarray(student.ppf(0.975, spare) * np.sqrt(np.maximum(np.diag(covariance), 0.0)))


def _has_it(run: Run) -> bool:
    return run.tau_meas is not None and bool(np.all(np.isfinite(run.tau_meas)))


def _in_units_of_command(run: Conditioned, gain: Floats, offset: Floats) -> Conditioned:
    """Return a run whose measured torque has no gain (n,) and no offset (n,) against the command any more."""
    assert run.run.tau_meas is not None
    return replace(run, run=replace(run.run, tau_meas=(run.run.tau_meas - offset) / gain))


def _measured(prepared: Prepared, run: Conditioned, early: Floats) -> Conditioned:
    measured = as_commanded(run.run, early)
    return condition(prepared.arm, measured, prepared.cutoff, run.noise, thin=True).as_recorded(run)
