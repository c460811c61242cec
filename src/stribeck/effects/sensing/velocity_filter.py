"""A drive that smooths the velocity it reports."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeAlias, final

import numpy as np
from numpy.typing import NDArray
from scipy import signal
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

from stribeck.model.effect import SensingEffect
from stribeck.model.scale import Scale
from stribeck.model.values import Observed, Parameter, Record

Floats: TypeAlias = NDArray[np.float64]
Filter: TypeAlias = Callable[[Floats, float], Floats]
"""Signal and lag at low frequency, samples, to the filtered signal."""

# Hz: what is compared lies below one of these, and below a fifth of the sample rate: noise of either record hides a lag
# above
TOPS = 20.0, 5.0
LONGEST = 0.5  # s
GROUPS = 8  # of runs, at most, that are left out in turn
SHORTEST = 50  # samples: of fewer nothing is told
LEAST = 0.5  # of the squared difference that a lag must explain
# of twice the logarithm of their likelihoods, that a lag is better than a delay: a late record, of either channel, is
# not a filter
RATHER = 10.0
UNSURE = 2.0  # times what is known of the noise in a position, which it may be
BETTER = 1.5  # times what a lag leaves, a difference of two positions must leave
QUOTIENT = 0.5  # samples: so late is the difference of two positions, the mean of the velocity between them
FINE = 1e-3  # s: longest step between which slopes are taken to be straight
TINY = 1e-12  # of a velocity's power: less is rounding
AT_ONCE = 3e-3  # s: any drive smooths its velocity by as much
USUAL = 8e-3  # s: and many, with coarse encoders, by as much at all joints
DIFFERENCES = 2.0  # samples: nor does anyone take differences of positions without smoothing them over so many


@final
class VelocityFilter(SensingEffect):
    """A lag of the recorded velocity, which shows against the recorded position's own slope.

    One pole, two equal ones, two by Butterworth, or a moving average: ``time`` is the lag at low frequency. Torque and
    position know nothing of it; a controller that uses the reported velocity does.
    """

    name = "velocity_filter"
    channel = "sensing"
    equation = r"T \dot v_\mathrm{rec} + v_\mathrm{rec} = \dot q"
    symptom = "a recorded velocity that trails the slope of the recorded position, most where it changes fast"
    shows = "recorded velocity"
    source = "Ellis (2012), Control System Design Guide, ch. 14 (velocity from position)"
    parameters = (Parameter("time", "s", "lag of the filter at low frequency", 0.0, 0.0, LONGEST),)
    direct = True

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return ({"time": 0.01},)

    def ordinary(self, values: Mapping[str, float], scale: Scale) -> bool:
        return values["time"] < max(USUAL, DIFFERENCES * scale.sample_time)

    def observed(self, record: Record) -> Observed | None:
        if not record.velocity:
            return None
        every = list(zip(record.position, record.velocity, record.sample_time, strict=True))
        long = [run for run in every if len(run[0]) >= SHORTEST]
        seen = [self._seen([_Compared(*run, top) for run in long]) for top in TOPS] if long else []
        return max((found for found in seen if found is not None), key=lambda found: found.probability, default=None)

    def _seen(self, runs: list[_Compared]) -> Observed | None:
        alone = sum(run.misfit(0.0, _late) for run in runs)
        if alone <= TINY * sum(run.power for run in runs):  # of a joint at rest, or at one speed
            return None
        kind, (time, left) = min(((kind, _best(runs, kind)) for kind in KINDS), key=lambda found: found[1][1])
        if left > (1.0 - LEAST) * alone or time < AT_ONCE:
            return None
        quotient = sum(run.misfit(QUOTIENT * run.step, _average) for run in runs)
        if _better(runs, kind, time, left) < RATHER or left > quotient / BETTER:
            return None
        spread = _spread(runs, kind) + 0.02 * time
        return Observed({"time": (time, max(time - spread, 0.0), time + spread)}, 1.0 - left / alone)


class _Compared:
    """Slope of a position record and the recorded velocity, in the band that both can show."""

    def __init__(self, position: np.ndarray, velocity: np.ndarray, step: float, top: float) -> None:
        self.step = step
        top = min(top, 0.2 / step)
        self.independent = 2.0 * top * len(position) * step  # samples that the low-pass leaves
        self.low_pass = signal.butter(3, top, fs=1.0 / step, output="sos")
        self.parts = max(1, round(step / FINE))
        rows = np.arange(len(position))
        fine = np.arange((len(position) - 1) * self.parts + 1) / self.parts
        noises = _white(position), _rounding(position, self._smooth(position))
        self.slope, *rustles = (CubicSpline(rows, values)(fine, 1) / step for values in (position, *noises))
        self.rustle = max(rustles, key=lambda slope: self._squared(self._passed(slope, 0.0, _late)))
        self.seen = self._smooth(velocity)
        self.power = float(self.seen @ self.seen)
        self.known: dict[tuple[float, Filter], float] = {}  # searches begin on one grid of times

    def _smooth(self, values: np.ndarray) -> np.ndarray:
        return np.asarray(signal.sosfiltfilt(self.low_pass, values))

    def misfit(self, time: float, kind: Filter) -> float:
        """Return the squared difference that is left with the slope lagged by a time (s)."""
        if (time, kind) not in self.known:
            self.known[time, kind] = self._misfit(time, kind)
        return self.known[time, kind]

    def _misfit(self, time: float, kind: Filter) -> float:
        return self._squared(self._passed(self.slope, time, kind) - self.seen)

    def rustling(self, time: float, kind: Filter) -> float:
        """Return the part of the squared difference that the position's noise is, with its slope lagged by a time."""
        return self._squared(self._passed(self.rustle, time, kind))

    def _passed(self, slope: Floats, time: float, kind: Filter) -> Floats:
        moved = kind(slope, time / self.step * self.parts) if time > 0.0 else slope
        return self._smooth(moved[:: self.parts])

    def _squared(self, values: Floats) -> float:
        edge = min(len(values) // 4, round(0.2 / self.step))
        inner = values[edge : -edge or None]
        return float(inner @ inner)


def _white(position: Floats) -> Floats:
    """Return white noise as strong as that of a position record, by what lies in the upper half of its band."""
    high = signal.butter(4, 0.5, "highpass", output="sos")
    edge = len(position) // 8
    upper = signal.sosfiltfilt(high, position - np.linspace(position[0], position[-1], len(position)))
    size = np.sqrt(2.0) * np.std(upper[edge : -edge or None])
    return np.asarray(size * np.random.default_rng(0).standard_normal(len(position)))


def _rounding(position: Floats, smooth: Floats) -> Floats:
    """Return what an encoder of the record's smallest step adds to its smoothed position: slow saws, no white noise."""
    steps = np.abs(np.diff(position))
    step = float(np.min(steps[steps > 0.0], initial=np.inf))
    return np.asarray(step * np.round(smooth / step) - smooth) if np.isfinite(step) else np.zeros(len(position))


def _one_pole(values: Floats, samples: float) -> Floats:
    keep = np.exp(-1.0 / samples)
    mean = 0.5 * (values + np.concatenate([values[:1], values[:-1]]))  # between two samples
    return np.asarray(signal.lfilter([1.0 - keep], [1.0, -keep], mean, zi=[mean[0] * keep])[0])


def _two_poles(values: Floats, samples: float) -> Floats:
    return _one_pole(_one_pole(values, 0.5 * samples), 0.5 * samples)


def _butterworth(values: Floats, samples: float) -> Floats:
    """Return a low-pass of two poles, damped by 0.71, whose lag at low frequency is so many samples."""
    rate = np.sqrt(2.0) / samples
    b, a = signal.bilinear([rate**2], [1.0, np.sqrt(2.0) * rate, rate**2], 1.0)
    return np.asarray(signal.lfilter(b, a, values, zi=signal.lfilter_zi(b, a) * values[0])[0])


def _average(values: Floats, samples: float) -> Floats:
    """Return the mean over the last 2 ``samples``."""
    steps = np.arange(len(values), dtype=float)
    summed = np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]))])
    before = np.maximum(steps - 2.0 * samples, 0.0)
    moved = (summed - np.interp(before, steps, summed)) / np.maximum(steps - before, 1e-9)
    return np.where(steps > 0.0, moved, values)


def _late(values: Floats, samples: float) -> Floats:
    steps = np.arange(len(values), dtype=float)
    return np.interp(steps - samples, steps, values)


KINDS: tuple[Filter, ...] = (_one_pole, _two_poles, _butterworth, _average)


def _better(runs: list[_Compared], kind: Filter, time: float, left: float) -> float:
    """Return twice the logarithm of a lag's likelihood over a delay's, given what the lag leaves.

    A lag takes noise of the position from its slope besides: that is none of its merit.
    """
    late, by_delay = _best(runs, _late)
    noise_by_delay, noise = (sum(run.rustling(at, way) for run in runs) for at, way in ((late, _late), (time, kind)))
    merit = left + max(UNSURE * (noise_by_delay - noise), 0.0)
    least = TINY * sum(run.power for run in runs)
    return float(sum(run.independent for run in runs) * np.log(max(by_delay, least) / max(merit, least)))


def _spread(runs: list[_Compared], kind: Filter) -> float:
    """Return two standard errors of the time, s, by leaving out one group of runs after the other (Tukey 1958)."""
    groups = min(len(runs), GROUPS)
    if groups < 2:
        return 0.0
    without = [_best([run for k, run in enumerate(runs) if k % groups != i], kind)[0] for i in range(groups)]
    return 2.0 * float(np.std(without) * np.sqrt(groups - 1))


def _best(runs: list[_Compared], kind: Filter) -> tuple[float, float]:
    """Return the time (s) that leaves least, and what it leaves."""

    def left(time: float) -> float:
        return float(sum(run.misfit(time, kind) for run in runs))

    times = np.concatenate([[0.0], np.geomspace(0.25 * min(run.step for run in runs), LONGEST, 16)])
    k = int(np.argmin([left(time) for time in times]))
    bounds = float(times[max(k - 1, 0)]), float(times[min(k + 1, len(times) - 1)])
    found = minimize_scalar(left, bounds=bounds, method="bounded")
    return float(found.x), float(found.fun)
