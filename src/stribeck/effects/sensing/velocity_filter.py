"""A drive that smooths the velocity it reports."""

from __future__ import annotations

from typing import final

import numpy as np
from scipy import signal
from scipy.optimize import minimize_scalar

from stribeck.model.effect import SensingEffect
from stribeck.model.values import Observed, Parameter, Record, Scale

TOP = 20.0  # Hz: what is compared lies below this, and below a fifth of the sample rate
LONGEST = 0.5  # s
LEAST = 0.5  # of the squared difference that a lag must explain
RATHER = 1.5  # times what a delay leaves, a lag may leave: a late record, of either channel, is not a filter
LATER = 0.6  # samples: a difference quotient alone is half a sample late


@final
class VelocityFilter(SensingEffect):
    """A first-order lag of the recorded velocity, which shows against the recorded position's own slope.

    Torque and position know nothing of it; a controller that uses the reported velocity does.
    """

    name = "velocity_filter"
    channel = "sensing"
    equation = r"T \dot v_\mathrm{rec} + v_\mathrm{rec} = \dot q"
    symptom = "a recorded velocity that trails the slope of the recorded position, most where it changes fast"
    shows = "recorded velocity"
    source = "Ellis (2012), Control System Design Guide, ch. 14 (velocity from position)"
    parameters = (Parameter("time", "s", "time constant of the filter", 0.0, 0.0, LONGEST),)
    direct = True

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return ({"time": 0.01},)

    def observed(self, record: Record) -> Observed | None:
        if not record.velocity:
            return None
        runs = [_Compared(*run) for run in zip(record.position, record.velocity, record.sample_time, strict=True)]
        alone = sum(run.misfit(0.0) for run in runs)
        time, left = _best(runs)
        if left > (1.0 - LEAST) * alone or time < LATER * min(record.sample_time):
            return None
        if left > RATHER * _best(runs, late=True)[1]:
            return None
        each = np.array([_best([run])[0] for run in runs])
        spread = 2.0 * float(np.std(each)) / np.sqrt(len(each)) + 0.02 * time
        return Observed({"time": (time, max(time - spread, 0.0), time + spread)}, 1.0 - left / alone)


class _Compared:
    """Slope of a position record and the recorded velocity, in the band that both can show."""

    def __init__(self, position: np.ndarray, velocity: np.ndarray, step: float) -> None:
        self.step = step
        self.low_pass = signal.butter(3, min(TOP, 0.2 / step), fs=1.0 / step, output="sos")
        self.slope = np.gradient(position, step)
        self.seen = self._smooth(velocity)

    def _smooth(self, values: np.ndarray) -> np.ndarray:
        return np.asarray(signal.sosfiltfilt(self.low_pass, values))

    def misfit(self, time: float, *, late: bool = False) -> float:
        """Return the squared difference that is left with the slope lagged, or late, by a time (s)."""
        edge = min(len(self.slope) // 4, round(0.2 / self.step))
        moved = self._late(time) if late else self._lagged(time)
        left = (self._smooth(moved) - self.seen)[edge : -edge or None]
        return float(left @ left)

    def _lagged(self, time: float) -> np.ndarray:
        if time <= 0.0:
            return np.asarray(self.slope)
        keep = np.exp(-self.step / time)
        mean = 0.5 * (self.slope + np.concatenate([self.slope[:1], self.slope[:-1]]))  # between two samples
        return np.asarray(signal.lfilter([1.0 - keep], [1.0, -keep], mean, zi=[mean[0] * keep])[0])

    def _late(self, time: float) -> np.ndarray:
        t = self.step * np.arange(len(self.slope))
        return np.asarray(np.interp(t - time, t, self.slope))


def _best(runs: list[_Compared], *, late: bool = False) -> tuple[float, float]:
    """Return the time (s) that leaves least, and what it leaves."""

    def left(time: float) -> float:
        return float(sum(run.misfit(time, late=late) for run in runs))

    times = np.concatenate([[0.0], np.geomspace(0.25 * min(run.step for run in runs), LONGEST, 16)])
    k = int(np.argmin([left(time) for time in times]))
    bounds = float(times[max(k - 1, 0)]), float(times[min(k + 1, len(times) - 1)])
    found = minimize_scalar(left, bounds=bounds, method="bounded")
    return float(found.x), float(found.fun)
