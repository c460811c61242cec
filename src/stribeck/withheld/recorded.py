"""What recordings tell of the laboratory that made them: its clock, its encoders, and which joints it drives."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.signal import firwin

from stribeck.arm import Arm
from stribeck.errors import InputError
from stribeck.grid import uniform
from stribeck.run import Run
from stribeck.run.reading import as_read
from stribeck.run.turns import in_one_turn
from stribeck.withheld.plant import Array

ALIKE = 0.01  # by which rates differ, relative, that are one
BAND = 0.7  # of the Nyquist frequency, above which an arm seldom moves
TAPS = 129  # of the filter that looks there, at most
MOVES = 4.0  # encoder counts, within which a joint rests: its record then shows less noise than there is
STRAYS = 20.0  # standard deviations of its noise, from end to end, that no record of a joint at rest strays


def made_even(runs: Sequence[Run], notes: list[str]) -> tuple[list[Run], list[Run]]:
    """Return runs as an encoder gives them that counts on and is read in every row, and on uniform clocks besides.

    As a diagnosis takes them; ``notes`` are told what was done.
    """
    turned = in_one_turn(runs, notes)
    read, even, since = [as_read(run)[0] for run in turned], [], min(float(run.t[0]) for run in runs)
    for run in turned:
        one, said = uniform(run, since)
        notes.extend(said)
        even.append(one)
    return read, even


def usual_rate(runs: Sequence[Run], notes: list[str]) -> float:
    """Return the rate of most of the recorded time, Hz; ``notes`` are told of runs that have another."""
    steps, lasting = np.array([run.sample_time for run in runs]), np.array([run.duration for run in runs])
    alike = np.abs(steps[:, None] / steps - 1.0) < ALIKE
    usual = int(np.argmax(alike @ lasting))
    rate = float(f"{1.0 / steps[usual]:.6g}")
    others = ", ".join(run.name for run, same in zip(runs, alike[usual], strict=True) if not same)
    if others:
        notes.append(f"recorded at {rate:g} Hz, as most of the time was; at another rate: {others}")
    return rate


def encoder_count(arm: Arm, runs: Sequence[Run], k: int) -> float:
    """Return the encoder count, rad: the arm file's, or the smallest step where all steps are multiples of it."""
    stated = arm.joints[k].encoder_resolution
    if stated is not None:
        return stated
    steps = np.abs(np.concatenate([np.diff(run.q[:, k]) for run in runs]))
    steps = steps[steps > 1e-12]
    if len(steps) == 0:
        return 0.0
    count = float(steps.min())
    off = np.abs(steps / count - np.round(steps / count))
    return count if float(np.quantile(off, 0.99)) < 0.05 and float(np.median(steps)) < 1e3 * count else 0.0


def encoder_noise(runs: Sequence[Run], k: int, count: float) -> float:
    """Return the noise of an encoder beyond its rounding, rad, from the top of the band, where no motion is left.

    Parameters
    ----------
    runs : sequence of Run
        On uniform clocks.
    k : int
        The joint.
    count : float
        Of its encoder, rad.
    """
    records = [run.q[:, k] for run in runs]
    fast = np.concatenate([_fast(q) for q in records if np.ptp(q) > MOVES * count] or [_fast(q) for q in records])
    total = 1.4826 * float(np.median(np.abs(fast)))
    return math.sqrt(max(total**2 - count**2 / 12.0, 0.0))


def _fast(q: Array) -> Array:
    """Return the fast part of a record (N,), scaled to let white noise be as large as it is."""
    length = min(TAPS, len(q) // 4) // 2 * 2 + 1
    fourth = np.convolve([1.0, -2.0, 1.0], [1.0, -2.0, 1.0])  # what is slow is next to nothing in fourth differences
    taps = np.convolve(fourth, firwin(length, BAND, window=("kaiser", 14.0), pass_zero=False))
    return np.asarray(np.convolve(q - q.mean(), taps, mode="valid") / np.linalg.norm(taps))


def held_joints(
    arm: Arm, runs: Sequence[Run], noise: Sequence[float], counts: Sequence[float]
) -> list[tuple[int, ...]]:
    """Return of each run the joints that a brake or a pin holds: at rest all along, under a torque that is constant.

    Parameters
    ----------
    arm : Arm
    runs : sequence of Run
    noise, counts : sequence of float
        Of the encoders, rad.

    Raises
    ------
    InputError
        Where a joint moves without a torque, or none is driven.
    """
    at_rest = STRAYS * np.array(noise) + 2.0 * np.array(counts)
    held = []
    for run in runs:
        still, idle = np.ptp(run.q, axis=0) <= at_rest, np.ptp(run.tau, axis=0) == 0.0
        for k in np.flatnonzero(~still & idle & (run.tau[0] == 0.0)):
            what = f"{run.name}: joint {arm.names[k]} moves, but its torque is zero all along"
            do = f"give what was commanded as tau{k + 1}; a joint without a drive cannot be recorded"
            raise InputError(what, "", do)
        held.append(tuple(int(k) for k in np.flatnonzero(still & idle)))
    if all(len(joints) == arm.n for joints in held):
        what = "no joint is driven in any recording"
        raise InputError(what, ", ".join(run.name for run in runs), "give recordings in which the arm moves")
    return held
