"""Random torque: what is left where no law could be, for it knows nothing of the motion.

What shakes an arm without a period, and the noise of its drive, is coloured: it lies above the floor that encoders
and white noise make. No model of the arm can follow it. It shows as a residual that is as strong wherever the joint
moves, normally distributed, and not foretold by the motion of other runs; a law of the arm that is missing leaves one
that is none of these.

The arm answers to what shakes it, and its loop to the arm: a filter that is laid over random torque closes a little
of it, surely and on all runs, for what it is fed with holds the answer. Such a little counts for nothing (``gates``).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from stribeck.gap.model import Model
from stribeck.gap.prepare import Prepared
from stribeck.gap.result import RandomTorque
from stribeck.gap.spread import noise_power, spread
from stribeck.gap.where import analysis_signals, region_masks
from stribeck.identify.conditioning import Conditioned

Floats = NDArray[np.float64]

ABOVE = 1.2  # residual over noise floor from which there is anything to tell
WINDOW = 0.25  # s of motion, whose mean squares are compared
LEAST_WINDOWS = 12
LEAST_INDEPENDENT = 40.0  # rows: of what wanders slowly, too little is seen
SURROGATES = 50
EVEN = 1.25  # factor by which the spread of the windows may differ from that of steady noise of the same spectrum
KURTOSIS = (2.5, 3.7)  # 3 for a normal distribution
FORETOLD = 0.65  # of the squares, by the motion: the arm moves a little with what shakes it
RIDGE = 100.0  # rows that the ridge is worth
LAGS = (-3, 0, 3)  # rows


def random_torque(prepared: Prepared, model: Model, floor: Floats, seed: int = 0) -> tuple[RandomTorque, ...]:
    """Return what a model leaves beyond the noise floor (n,), N m rms, at joints where that is random."""
    residual = np.concatenate([model.fit.residual, model.held])
    beyond = np.mean(residual**2, axis=0) / floor**2
    found = []
    for j, bandwidth in random_joints(prepared, model, floor, seed).items():
        if beyond[j] > ABOVE**2:
            unit = "N" if prepared.arm.joints[j].kind == "prismatic" else "N m"
            rms = float(np.sqrt(beyond[j] - 1.0) * floor[j])
            found.append(RandomTorque(prepared.arm.names[j], rms, bandwidth, unit))
    return tuple(found)


def random_joints(prepared: Prepared, model: Model, floor: Floats, seed: int = 0) -> dict[int, float]:
    """Return the joints at which what a model leaves is random, whatever its size, and its bandwidth, Hz.

    Notes
    -----
    Steadiness is judged against surrogates with the same spectrum and random phases (Theiler, Eubank, Longtin,
    Galdrikian & Farmer 1992), where the joint moves: at rest, stiction hides what shakes it.
    """
    runs = (*prepared.fit, *prepared.held)
    residual = np.concatenate([model.fit.residual, model.held])
    even = residual / spread(residual, noise_power(prepared.noise, floor, len(residual)))
    found = {}
    for j in range(residual.shape[1]):
        bandwidth = _bandwidth(even[:, j], runs)
        if np.pi * bandwidth * len(residual) * _step(runs) < LEAST_INDEPENDENT:
            continue
        if _steady(even[:, j], runs, j, np.random.default_rng([seed, j])) and not _follows(even[:, j], runs):
            found[j] = bandwidth
    return found


def _steady(residual: Floats, runs: Sequence[Conditioned], joint: int, rng: np.random.Generator) -> bool:
    """Return whether a residual (M,) is as strong everywhere in motion, and normally distributed there."""
    motion = region_masks(runs, joint)["motion"]
    moving = np.any([mask for name, mask in motion.items() if name.endswith("velocity")], axis=0)
    if not np.any(moving):
        return False
    edges = _edges(runs)
    width = max(2, round(WINDOW / _step(runs)))
    spread_here, count = _uneven(residual, moving, edges, width)
    if count < LEAST_WINDOWS:
        return False
    free = residual[moving]
    kurtosis = float(np.mean(free**4) / np.mean(free**2) ** 2)
    parts = np.split(residual, edges)
    steady = [
        _uneven(np.concatenate([_surrogate(part, rng) for part in parts]), moving, edges, width)[0]
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


def _follows(residual: Floats, runs: Sequence[Conditioned]) -> bool:
    """Return whether the motion foretells a residual (M,): by the other runs, or the other parts of a single one."""
    features = np.column_stack([*_features(runs), np.ones(len(residual))])
    lengths = [len(run.analysis_index) for run in runs]
    group = np.repeat(np.arange(len(runs)), lengths) if len(runs) > 1 else np.arange(len(residual)) * 4 // len(residual)
    left = 0.0
    for k in np.unique(group):
        others = group != k
        normal = features[others].T @ features[others] + RIDGE * np.eye(features.shape[1])
        weights = np.linalg.solve(normal, features[others].T @ residual[others])
        left += float(np.sum((residual[~others] - features[~others] @ weights) ** 2))
    return left < (1.0 - FORETOLD) * float(np.sum(residual**2))


def _features(runs: Sequence[Conditioned]) -> list[Floats]:
    """Return what laws of an arm are made of (M,), each of unit size, at a few lags."""
    signals = analysis_signals(runs)
    out: list[Floats] = []
    for j in range(signals["position"].shape[1]):
        position = signals["position"][:, j]
        speed, acceleration, torque = (
            signals[name][:, j] / max(float(np.std(signals[name][:, j])), 1e-12)
            for name in ("velocity", "acceleration", "command")
        )
        direction = np.tanh(5.0 * speed)
        out += [np.sin(position), np.cos(position), speed, acceleration, torque, direction]
        out += [speed * np.abs(speed), torque * direction, np.gradient(torque), np.gradient(acceleration)]
    return [np.roll(feature, lag) for feature in out for lag in LAGS]


def _bandwidth(residual: Floats, runs: Sequence[Conditioned]) -> float:
    """Return the corner, Hz, of first-order noise that forgets as fast as a residual (M,) does."""
    parts = np.split(residual, _edges(runs))
    alike = sum(float(part[:-1] @ part[1:]) for part in parts) / sum(float(part @ part) for part in parts)
    return float(-np.log(np.clip(alike, 1e-3, 0.999)) / (2.0 * np.pi * _step(runs)))


def _edges(runs: Sequence[Conditioned]) -> np.ndarray:
    return np.cumsum([len(run.analysis_index) for run in runs])[:-1]


def _step(runs: Sequence[Conditioned]) -> float:
    return float(runs[0].decimation * runs[0].sample_time)
