"""Random torque: what is left where no law could be, for it knows nothing of the motion.

What shakes an arm without a period, and the noise of its drive, is coloured: it lies above the floor that encoders
and white noise make. No model of the arm can follow it. It shows as a residual that is as strong wherever the joint
moves, in every run, normally distributed, and for the most part not foretold by the motion of other runs; of a law of
the arm that is missing, one of these is hardly ever true. Short recordings cannot tell: there, and where a good part of
the torque is at stake, what is left stays unexplained.

The arm answers to what shakes it, and its loop to the arm: a filter that is laid over random torque closes a little
of it, surely and on all runs, for what it is fed with holds the answer. Such a little counts for nothing (``gates``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stribeck.arm import unit_at
from stribeck.gap.fitted.model import Model
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.records.regions import analysis_signals, motion_masks
from stribeck.gap.records.spread import noise_power, spread
from stribeck.gap.result import RandomTorque
from stribeck.identify.conditioning import Conditioned

Floats = NDArray[np.float64]

ABOVE = 1.2  # residual over noise floor from which there is anything to tell
HUSHED = 0.05  # of the noise floor, below which a residual is a joint's that rests
WINDOW = 0.25  # s of motion, whose mean squares are compared
LEAST_WINDOWS = 12
LOUDEST = 0.08  # of the torque asked for: twice what is loud among simulated drives; a law may leave more
SURROGATES = 50
EVEN = 1.25  # factor by which the spread of the windows may differ from that of steady noise of the same spectrum
KURTOSIS = (2.5, 3.7)  # 3 for a normal distribution
LEAST_UNFORETOLD = 0.35  # of the squares: the arm, and its loop, move with what shakes it
RIDGE = 100.0  # rows that the ridge is worth
LAGS = (-3, 0, 3)  # rows
WAVES, OF_FRICTION = 12, 4  # over the travel: of what repeats with position, and of that with the sense of motion


@dataclass(frozen=True)
class Randomness:
    """Of a random residual: its ``bandwidth``, Hz, and the ``share`` of its squares that no motion foretells."""

    bandwidth: float
    share: float


def random_torque(prepared: Prepared, model: Model, floor: Floats, seed: int = 0) -> tuple[RandomTorque, ...]:
    """Return what a model leaves on held-out runs beyond the noise floor (n,), N m rms, at joints where it is random.

    What other runs foretell of it is left out: it may be a law's.
    """
    beyond = np.mean(model.held**2, axis=0) / floor**2
    found = []
    for j, random in random_joints(prepared, model, floor, seed).items():
        if beyond[j] > ABOVE**2:
            unit = unit_at("N m", prepared.arm.joints[j].kind)
            rms = float(np.sqrt(random.share * (beyond[j] - 1.0)) * floor[j])
            found.append(RandomTorque(prepared.arm.names[j], rms, random.bandwidth, unit))
    return tuple(found)


def added_power(random: Sequence[RandomTorque], names: Sequence[str]) -> Floats:
    """Return the power (n,), N^2 m^2, by which random torque raises the noise of the joints of these names."""
    return np.array([sum(row.rms**2 for row in random if row.joint == name) for name in names], dtype=float)


def loud(random: Sequence[RandomTorque], names: Sequence[str], floor: Floats) -> list[str]:
    """Return a warning for each joint where random torque is more than the other noise (n,), N m rms."""
    return [
        f"{row.joint}: {row.rms:.3g} {row.unit} rms of random torque, more than other noise; no model follows it"
        for row in random
        if row.rms > floor[names.index(row.joint)]
    ]


def random_joints(prepared: Prepared, model: Model, floor: Floats, seed: int = 0) -> dict[int, Randomness]:
    """Return the joints at which what a model leaves is random, whatever its size.

    Notes
    -----
    Steadiness is judged against surrogates with the same spectrum and random phases (Theiler, Eubank, Longtin,
    Galdrikian & Farmer 1992), as strong in every run, where the joint moves: at rest, stiction hides what shakes it.
    From fewer independent rows than it has features, the motion foretells nothing, law or not: that says nothing.
    """
    runs = (*prepared.fit, *prepared.held)
    residual, features = model.whole, _features(runs)
    rms = np.sqrt(np.mean(residual**2, axis=0))
    loudest = LOUDEST * np.sqrt(np.mean(analysis_signals(runs)["command"] ** 2, axis=0))
    even = residual / spread(residual, noise_power(prepared.noise, floor, len(residual), model.rows))
    found = {}
    for j in (int(j) for j in np.flatnonzero((rms > HUSHED * floor) & (rms < loudest))):
        bandwidth = _bandwidth(even[:, j], runs)
        if np.pi * bandwidth * len(residual) * _step(runs) < features.shape[1]:
            continue
        if _steady(even[:, j], runs, j, np.random.default_rng([seed, j])):
            share = _unforetold(even[:, j], runs, features)
            if share > LEAST_UNFORETOLD:
                found[j] = Randomness(bandwidth, share)
    return found


def _steady(residual: Floats, runs: Sequence[Conditioned], joint: int, rng: np.random.Generator) -> bool:
    """Return whether a residual (M,) is as strong everywhere in motion, and normally distributed there."""
    motion = motion_masks(runs, joint)
    moving = np.any([mask for name, mask in motion.items() if name.endswith("velocity")], axis=0)
    if not np.any(moving):
        return False
    edges = _edges(runs)
    width = max(2, round(WINDOW / _step(runs)))
    spread_here, count = _uneven(residual, moving, edges, width)
    if count < LEAST_WINDOWS:
        return False
    free = residual[moving]
    whole = float(np.mean(free**2))
    kurtosis = float(np.mean(free**4)) / whole**2
    alike = []
    for part, here in zip(np.split(residual, edges), np.split(moving, edges), strict=True):
        own = float(np.mean(part[here] ** 2)) if np.sum(here) >= width else whole
        alike.append(part * np.sqrt(whole / max(own, 1e-6 * whole)))
    steady = [
        _uneven(np.concatenate([_surrogate(part, rng) for part in alike]), moving, edges, width)[0]
        for _ in range(SURROGATES)
    ]
    ratio = spread_here / float(np.mean(steady))
    return 1.0 / EVEN < ratio < EVEN and KURTOSIS[0] < kurtosis < KURTOSIS[1]


def _uneven(residual: Floats, moving: np.ndarray, edges: np.ndarray, width: int) -> tuple[float, int]:
    """Return how the mean squares of windows of motion scatter, in logarithm, and how many windows there are."""
    squares: list[Floats] = []
    for part, here in zip(np.split(residual, edges), np.split(moving, edges), strict=True):
        rows = part[here]
        whole = len(rows) // width
        squares.append(np.mean(rows[: whole * width].reshape(whole, width) ** 2, axis=1))
    every = np.concatenate(squares)
    if not len(every):
        return 0.0, 0
    return float(np.std(np.log(every + 0.05 * np.mean(every)))), len(every)


def _surrogate(part: Floats, rng: np.random.Generator) -> Floats:
    spectrum = np.fft.rfft(part - part.mean())
    turned = np.abs(spectrum) * np.exp(2j * np.pi * rng.random(len(spectrum)))
    return np.asarray(np.fft.irfft(turned, len(part)) + part.mean())


def _unforetold(residual: Floats, runs: Sequence[Conditioned], features: Floats) -> float:
    """Return the share of a residual's squares (M,) that the motion does not foretell, by the other runs.

    Of a single run, by its other parts.
    """
    lengths = [len(run.analysis_index) for run in runs]
    group = np.repeat(np.arange(len(runs)), lengths) if len(runs) > 1 else np.arange(len(residual)) * 4 // len(residual)
    left = 0.0
    for k in np.unique(group):
        others = group != k
        normal = features[others].T @ features[others] + RIDGE * np.eye(features.shape[1])
        weights = np.linalg.solve(normal, features[others].T @ residual[others])
        left += float(np.sum((residual[~others] - features[~others] @ weights) ** 2))
    return min(left / float(np.sum(residual**2)), 1.0)


def _features(runs: Sequence[Conditioned]) -> Floats:
    """Return what laws of an arm are made of (M, K): what moves at a few lags, waves over the travel, a constant."""
    signals = analysis_signals(runs)
    out: list[Floats] = []
    waves: list[Floats] = []
    for j in range(signals["position"].shape[1]):
        position = signals["position"][:, j]
        turn = 2.0 * np.pi * position / max(float(np.ptp(position)), 1e-9)
        waves += [wave(k * turn) for k in range(1, WAVES + 1) for wave in (np.sin, np.cos)]
        speed, acceleration, torque = (
            signals[name][:, j] / max(float(np.std(signals[name][:, j])), 1e-12)
            for name in ("velocity", "acceleration", "command")
        )
        direction = np.tanh(5.0 * speed)
        waves += [wave(k * turn) * direction for k in range(1, OF_FRICTION + 1) for wave in (np.sin, np.cos)]
        out += [np.sin(position), np.cos(position), speed, acceleration, torque, direction]
        out += [speed * np.abs(speed), torque * direction, np.gradient(torque), np.gradient(acceleration)]
    moving = [np.roll(feature, lag) for feature in out for lag in LAGS]
    return np.column_stack([*waves, *moving, np.ones(len(moving[0]))])


def _bandwidth(residual: Floats, runs: Sequence[Conditioned]) -> float:
    """Return the corner, Hz, of first-order noise that forgets as fast as a residual (M,) does."""
    parts = np.split(residual, _edges(runs))
    alike = sum(float(part[:-1] @ part[1:]) for part in parts) / sum(float(part @ part) for part in parts)
    return float(-np.log(np.clip(alike, 1e-3, 0.999)) / (2.0 * np.pi * _step(runs)))


def _edges(runs: Sequence[Conditioned]) -> np.ndarray:
    return np.cumsum([len(run.analysis_index) for run in runs])[:-1]


def _step(runs: Sequence[Conditioned]) -> float:
    """Return the time between rows, s; of runs of different rates, the middle one of all rows."""
    steps = [run.decimation * run.sample_time for run in runs]
    return float(np.median(np.repeat(steps, [len(run.analysis_index) for run in runs])))
