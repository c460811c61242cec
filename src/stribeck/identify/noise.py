"""Noise of recorded positions, read off the part of their spectrum where an arm seldom moves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import signal

from stribeck.arm import Arm, unit_at
from stribeck.quantum import smallest_step
from stribeck.run import Run
from stribeck.run.reading import as_read

BAND = (0.7, 0.98)  # share of the Nyquist frequency in which noise is looked for
STRETCH = (0.5, 128)  # s, and samples at least, that have their say each: short, so that few hold a blow
QUIET = 0.2  # of the stretches that are the quietest: blows, stops and chatter only ever add
SHORT = 1.25  # by which white noise's quietest are short of its power, times the root of the frequencies in the band
MOVES = 4.0  # encoder steps, within which a joint rests: its record then shows less noise than there is
LEAST_STRETCHES = 4
AT_REST = 10.0  # standard deviations of its noise, within which the record of a joint that rests stays
FINER = 4.0  # times less than steps of the stated resolution leave: the record is of another encoder, or filtered
CLEARLY = 1.4  # times the noise of all, from which a run has its own


def encoder_noise(arm: Arm, runs: Sequence[Run], recorded: Sequence[Run] = ()) -> np.ndarray:
    """Return the standard deviation (n,) of white noise on the recorded positions of each joint, rad.

    That of the encoder, the same in all uniform runs: what a run shows beyond the others is how its joints moved. Its
    steps show in the runs as they were ``recorded``, not where a clock that jitters had them resampled.
    """
    times, steps = [run.sample_time for run in runs], _steps(runs, recorded)
    known = [max(joint.encoder_resolution or 0.0, step) for joint, step in zip(arm.joints, steps, strict=True)]
    return np.array([position_noise([run.q[:, j] for run in runs], times, known[j]) for j in range(arm.n)])


def doubtful_resolutions(arm: Arm, runs: Sequence[Run], recorded: Sequence[Run] = ()) -> list[str]:
    """Return a warning for each joint whose moving record is far smoother than steps of the stated resolution.

    The parameters are those of :func:`encoder_noise`, which counts on what is stated: as long as it is too coarse,
    noise hides what it should not.
    """
    said = []
    for j, (joint, step) in enumerate(zip(arm.joints, _steps(runs, recorded), strict=True)):
        stated = joint.encoder_resolution or 0.0
        found = [_stretches(run.q[:, j], run.sample_time) for run in runs]
        power, reach = (np.concatenate(values) for values in zip(*found, strict=True))
        moving = reach > MOVES * stated
        if np.sum(moving) < LEAST_STRETCHES:
            continue
        finer = max(step, float(np.sqrt(12.0 * np.quantile(power[moving], QUIET))))
        if stated > FINER * finer:
            unit = unit_at("rad", joint.kind)
            what = f"{joint.name}: the arm file's encoder_resolution is {stated:.3g} {unit}, but recorded positions"
            said.append(f"{what} scatter as of steps of {finer:.2g} {unit}: correct it, unless they were filtered")
    return said


def _steps(runs: Sequence[Run], recorded: Sequence[Run]) -> list[float]:
    """Return the quantum of each joint's record, rad, as it was recorded; 0 where there is none."""
    read = [as_read(run)[0] for run in recorded] or runs
    return [smallest_step(*(run.q[:, j] for run in read))[0] for j in range(runs[0].n)]


def noise_of_run(arm: Arm, run: Run, shared: np.ndarray) -> np.ndarray:
    """Return the noise (n,) of one run, rad: the ``shared`` one (n,), or its own where its rests clearly show more.

    Where a joint rests there is no motion that would pass for noise.
    """
    noise = shared.copy()
    for j in range(arm.n):
        power, reach = _stretches(run.q[:, j], run.sample_time)
        rests = reach < AT_REST * np.sqrt(power)
        if np.sum(rests) >= LEAST_STRETCHES:
            own = float(np.sqrt(np.quantile(power[rests], QUIET)))
            noise[j] = own if own > CLEARLY * shared[j] else shared[j]
    return noise


def position_noise(
    positions: Sequence[np.ndarray], sample_times: Sequence[float], resolution: float | None = None
) -> float:
    """Return the standard deviation of white noise on the position records of one joint, rad.

    Parameters
    ----------
    positions : sequence of array (N,)
        Recorded positions, rad, each uniform in time.
    sample_times : sequence of float
        s.
    resolution : float or None
        Encoder resolution, rad, where known; the records' own smallest step where that is coarser.

    Notes
    -----
    The median of a periodogram in the upper band is robust against resonances, and the quietest fifth of all
    stretches against what is broad and short: where a play hits, or a joint stops, a position has a bend, which at
    these frequencies is hundreds of times an encoder's noise. Quantisation gives at least resolution / sqrt(12)
    (Widrow & Kollar 2008, *Quantization Noise*), also where the records hardly move.
    """
    step = max(resolution or 0.0, smallest_step(*positions)[0])
    found = [_stretches(position, h) for position, h in zip(positions, sample_times, strict=True)]
    power, reach = (np.concatenate(values) for values in zip(*found, strict=True))
    moving = reach > MOVES * step
    if np.sum(moving) >= LEAST_STRETCHES:
        power = power[moving]
    white = float(np.sqrt(np.quantile(power, QUIET)))
    return float(max(white, step / np.sqrt(12.0), 1e-12))


def _stretches(position: np.ndarray, sample_time: float) -> tuple[np.ndarray, np.ndarray]:
    """Return stretches that overlap by half: power of white noise, rad^2, if quiet, and how far the joint goes."""
    length = min(max(round(STRETCH[0] / sample_time), STRETCH[1]), len(position) - 2)
    frequency, _, density = signal.spectrogram(
        np.diff(position, 2), fs=1.0 / sample_time, window="hann", nperseg=length, noverlap=length // 2
    )
    nyquist = 0.5 / sample_time
    band = (frequency > BAND[0] * nyquist) & (frequency < BAND[1] * nyquist)
    gain = (2 * np.sin(np.pi * frequency[band] * sample_time)) ** 4  # of the second difference
    power = np.median(density[band] / gain[:, None], axis=0) / np.log(2.0) * nyquist
    power /= max(1.0 - SHORT / np.sqrt(np.sum(band)), 0.5)
    starts = np.arange(density.shape[1]) * (length - length // 2)
    return power, np.array([np.ptp(position[i : i + length]) for i in starts])
