"""Noise in the torque itself: the part of a residual that has no memory beyond the analysis filter's own.

Encoder noise is known beforehand; a motor's torque noise shows in the residual alone. No law of the arm leaves a
residual without memory at every moment, so what is white through the filter is noise, not a gap.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy import optimize, signal

from stribeck.gap.fitted.model import Model
from stribeck.gap.fitted.noisy import put_back
from stribeck.gap.records.prepare import Prepared
from stribeck.identify.conditioning import Conditioned

LAGS = 12
NARROWER = (0.6, 0.35, 0.2, 0.1, 0.05, 0.02)  # bandwidths of residuals with a memory, over the analysis cutoff
SEGMENT = 16  # rows
UPPER = (0.55, 0.95)  # of the cutoff: the band where motions leave least
STEADY = 1.5  # a moment's violence (stops, knocks) is no noise: it may exceed the median moment's by this much
ALIKE = 0.02  # of the time between rows, within which runs are told as one
LEAST_MOTION = 200  # rows: less has no median that one could go by
MOSTLY_GONE = 0.5  # of a floor, rms, below which what is left shows that it was none
MOSTLY, PARTLY = 0.5, 0.1  # of a short stretch, and of a run, that must be motion


def noise_of_best(
    floor: np.ndarray, models: Sequence[Model], prepared: Prepared, before: np.ndarray | None = None
) -> np.ndarray:
    """Return the noise floor (n,), N m rms, raised to what is white in the residual of each joint's best model.

    Parameters
    ----------
    floor : array (n,)
        What encoder noise and filters leave, N m rms.
    models : sequence of Model
        Fitted to the same runs; each joint is judged by the one that leaves it least, of those without a compliance:
        noise in the torque is whole in these alone. But what rings in a band as wide looks as white: what one with a
        compliance does not leave, with the noise that it takes put back, is none.
    prepared : Prepared
    before : array (n,) or None
        The floor as other models told it, which stands where all of these have a compliance, unless one takes most of
        it: that rang.
    """
    stiff = [model for model in models if model.noise is None]
    soft = [model for model in models if model.noise is not None]
    if before is not None and not stiff:
        told = [np.where(_known(prepared, model), _left_with_noise(prepared, model, before), np.inf) for model in soft]
        left = np.min(told, axis=0)
        return np.asarray(np.where(left < MOSTLY_GONE * before, np.maximum(floor, left), before))
    runs = (*prepared.fit, *prepared.held)
    whole = [model.whole for model in stiff or models]
    best = np.argmin([np.mean(residual**2, axis=0) for residual in whole], axis=0)
    white = [white_rms(whole[best[j]][:, j], runs, prepared.cutoff, j) for j in range(len(floor))]
    raised = np.maximum(floor, white)
    for model in soft if stiff else []:
        raised = np.maximum(floor, np.minimum(raised, _left_with_noise(prepared, model, raised)))
    return np.asarray(raised)


def _left_with_noise(prepared: Prepared, model: Model, floor: np.ndarray) -> np.ndarray:
    """Return what a model with a compliance leaves (n,), N m rms, with the noise that it takes put back."""
    return np.asarray(np.sqrt(np.mean(put_back(prepared, model.whole, model.noise, floor) ** 2, axis=0)))


def _known(prepared: Prepared, model: Model) -> np.ndarray:
    """Return at which joints (n,) it is known how much of the noise a model with a compliance takes."""
    told, reference = model.noise, prepared.reference
    return np.zeros(prepared.arm.n, dtype=bool) if told is None or reference is None else told.known(reference)


def white_rms(residual: np.ndarray, runs: Sequence[Conditioned], cutoff: float, joint: int) -> float:
    """Return the root mean square of a residual's white part.

    Parameters
    ----------
    residual : array (M,)
        Rows of all runs, one after the other.
    runs : sequence of Conditioned
    cutoff : float
        Of the analysis, Hz.
    joint : int
        Whose residual it is.

    Notes
    -----
    The residual's autocorrelation is decomposed, with weights that are not negative (Lawson & Hanson 1974), into that
    of noise through the filter and those of narrower spectra. The median power of short stretches in the upper band
    bounds the former, for bursts may look white as well. Of a joint that rests, they are those of motion, and count for
    as much of the time: stiction holds the torque's noise, too.
    """
    ends = np.cumsum([len(run.analysis_index) for run in runs])
    parts = np.split(residual, ends)[:-1]
    told = [(part, run) for part, run in zip(parts, runs, strict=True) if len(part) > 2 * SEGMENT]
    rows, power = sum(len(part) for part, _ in told), 0.0
    while told:  # runs of another rate have other rows
        near = [abs(math.log(_row(run) / _row(told[0][1]))) < ALIKE for _, run in told]
        power += _white_power([pair for pair, same in zip(told, near, strict=True) if same], cutoff, joint)
        told = [pair for pair, same in zip(told, near, strict=True) if not same]
    return math.sqrt(power / max(rows, 1))


def _row(run: Conditioned) -> float:
    """Return the time from one analysis sample to the next, s."""
    return run.sample_time * run.decimation


def _white_power(told: Sequence[tuple[np.ndarray, Conditioned]], cutoff: float, joint: int) -> float:
    """Return the sum of squares of the white part of residuals, each with its run, whose rows are as far apart."""
    pieces, runs = [part for part, _ in told], [run for _, run in told]
    correlation = np.sum([_lagged(piece) for piece in pieces], axis=0)
    power = float(correlation[0])
    if power <= 0.0:
        return 0.0
    share, _ = optimize.nnls(_atoms(runs[0], cutoff), correlation / power)
    resting = [run.stuck[run.analysis_index, joint] for run in runs]
    steady = STEADY * _steady_rms(pieces, resting, runs[0], cutoff)
    return min(min(float(share[0]), 1.0) * power, steady**2 * sum(map(len, pieces)))


def _lagged(values: np.ndarray) -> np.ndarray:
    """Return the sums of products (LAGS,) of values and their followers, as if no product were lost at the end."""
    n = len(values)
    return np.array([values[k:] @ values[: n - k] * n / (n - k) for k in range(LAGS)])


def _atoms(run: Conditioned, cutoff: float) -> np.ndarray:
    """Return autocorrelations (LAGS, K) of filtered noise: white, narrower ones, and a constant."""
    step = run.sample_time
    frequency = np.linspace(0.0, 0.5 / step, 4000)
    passed = np.abs(signal.freqz(run.taps, worN=2 * np.pi * frequency * step)[1]) ** 2
    spectra = [passed, *(passed * np.exp(-((frequency / (b * cutoff)) ** 2)) for b in NARROWER)]
    waves = np.cos(2 * np.pi * _row(run) * np.outer(np.arange(LAGS), frequency))
    columns = [waves @ spectrum / spectrum.sum() for spectrum in spectra]
    return np.array([*columns, np.ones(LAGS)]).T


def _steady_rms(pieces: Sequence[np.ndarray], resting: Sequence[np.ndarray], run: Conditioned, cutoff: float) -> float:
    """Return the rms of white noise with the median power in the upper part of the band.

    Of short stretches, which bursts do not fill, or of whole runs, where a tone is but a line: what is less.
    ``resting`` tells of each row whether its joint is stuck, 1, or moves, 0.
    """
    step = run.sample_time
    moves = [stuck < 0.5 for stuck in resting]
    if sum(int(np.sum(own)) for own in moves) < LEAST_MOTION:
        moves = [np.ones(len(piece), dtype=bool) for piece in pieces]
    densities = []
    for rows, least in ((SEGMENT, MOSTLY), (None, PARTLY)):
        powers = []
        for piece, own in zip(pieces, moves, strict=True):
            length = rows or len(piece)
            frequency, _, power = signal.spectrogram(
                piece, fs=1.0 / _row(run), window="hann", nperseg=length, noverlap=length // 2
            )
            band = (frequency >= UPPER[0] * cutoff) & (frequency <= UPPER[1] * cutoff)
            passed = np.abs(signal.freqz(run.taps, worN=2 * np.pi * frequency[band] * step)[1]) ** 2
            starts = np.arange(power.shape[1]) * (length - length // 2)
            part = np.array([np.mean(own[start : start + length]) for start in starts])
            kept = part > least
            powers.append((power[band][:, kept] / passed[:, None] / part[kept]).ravel())
        inside = np.concatenate(powers)
        if len(inside):
            densities.append(float(np.median(inside)))
    density = min(densities, default=0.0) / np.log(2.0)  # the median of chi-square with two degrees
    return float(np.sqrt(0.5 * density * np.mean(np.concatenate(moves)) * np.sum(run.taps**2) / step))
