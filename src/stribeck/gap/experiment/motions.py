"""Reference motions that tell effects apart, within what the recorded runs show that the arm can do."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid
from scipy.signal.windows import hann

from stribeck.arm import Arm
from stribeck.identify.conditioning import Conditioned

Floats = NDArray[np.float64]

REACHED = 0.95  # of the recorded range of positions
SOFTEST, HARDEST = 0.3, 0.04  # s, of a change of speed
MOST_BAND, BAND = 8.0, 0.5  # Hz, and of the analysis cutoff: what is commanded above is neither followed nor analysed


@dataclass(frozen=True)
class Reach:
    """What one joint was seen to do.

    Attributes
    ----------
    low, high : float
        Range of positions, rad.
    speed, acceleration : float
        The largest but for outliers, rad/s and rad/s^2.
    finest : float
        Smallest motion that the encoder shows well, rad.
    band : float
        Highest frequency, Hz.
    """

    low: float
    high: float
    speed: float
    acceleration: float
    finest: float
    band: float

    @property
    def still(self) -> bool:
        """Whether it came no further in a second than the encoder shows: nothing is known of how it may move."""
        return self.speed <= self.finest

    @property
    def travel(self) -> float:
        """Width of the range, rad."""
        return self.high - self.low

    @property
    def centre(self) -> float:
        """Middle of the range, rad."""
        return 0.5 * (self.low + self.high)

    def wider(self, factor: float) -> Reach:
        """Return a reach that is so much larger in range (but for more than half a turn either way) and speed."""
        half = max(min(0.5 * factor * self.travel, np.pi), 0.5 * self.travel)
        low, high = self.centre - half, self.centre + half
        return replace(self, low=low, high=high, speed=factor * self.speed, acceleration=factor * self.acceleration)


def reaches(runs: Sequence[Conditioned], cutoff: float) -> tuple[Reach, ...]:
    """Return what each joint did in conditioned runs analysed up to ``cutoff`` (Hz)."""
    signals = {
        name: np.concatenate([getattr(run, name) for run in runs]) for name in ("position", "velocity", "acceleration")
    }
    middle, half = 0.5 * (signals["position"].min(axis=0) + signals["position"].max(axis=0)), 0.5 * REACHED
    travel = np.ptp(signals["position"], axis=0)
    speed = np.quantile(np.abs(signals["velocity"]), 0.999, axis=0)
    acceleration = np.quantile(np.abs(signals["acceleration"]), 0.99, axis=0)
    noise = np.max([run.noise for run in runs], axis=0)
    band = min(MOST_BAND, BAND * cutoff)
    return tuple(
        Reach(
            float(middle[j] - half * travel[j]),
            float(middle[j] + half * travel[j]),
            float(speed[j]),
            float(acceleration[j]),
            float(10.0 * noise[j]),
            band,
        )
        for j in range(len(middle))
    )


@dataclass(frozen=True)
class Recorded:
    """From where to where the joints went in all recordings (n,), rad, and how fast, rad/s."""

    low: Floats
    high: Floats
    speed: Floats


def recorded(runs: Sequence[Conditioned]) -> Recorded:
    """Return how far and how fast the joints went in conditioned runs."""
    return Recorded(
        np.min([run.run.q.min(axis=0) for run in runs], axis=0),
        np.max([run.run.q.max(axis=0) for run in runs], axis=0),
        np.max([np.abs(run.velocity).max(axis=0) for run in runs], axis=0),
    )


def _course(t: Floats, velocity: Floats, reach: Reach) -> Floats:
    """Return positions from a velocity in steps (N,), its corners rounded within the acceleration, inside the range."""
    h = float(t[1] - t[0])
    jump = float(np.max(np.abs(np.diff(velocity)), initial=0.0))
    width = float(np.clip(2.0 * jump / max(reach.acceleration, 1e-9), HARDEST, SOFTEST))
    window = hann(max(3, round(width / h)) + 2)[1:-1]
    smooth = np.convolve(velocity, window / window.sum(), mode="same")
    return _placed(np.asarray(cumulative_trapezoid(smooth, t, initial=0.0)), reach)


def _placed(course: Floats, reach: Reach) -> Floats:
    """Return positions shifted to the middle of the range, and made smaller where they do not fit."""
    size = float(np.ptp(course))
    factor = min(1.0, reach.travel / size) if size > 0.0 else 1.0
    return np.asarray(reach.centre + factor * (course - 0.5 * (course.min() + course.max())))


def _levels(t: Floats, speeds: Sequence[float] | Floats, shares: Sequence[float] | Floats) -> Floats:
    """Return a velocity (N,) that holds each of ``speeds`` for its share of the time, at rest at both ends."""
    rest = 0.03 * float(t[-1] - t[0])
    edges = t[0] + rest + np.cumsum(shares) / np.sum(shares) * (t[-1] - t[0] - 2.0 * rest)
    place = np.searchsorted(edges, t, side="right")
    held = np.append(np.asarray(speeds, dtype=np.float64), 0.0)[place]
    return np.asarray(np.where(t < t[0] + rest, 0.0, held))


def slow_reversals(t: Floats, reach: Reach) -> Floats:
    """Ramps forth and back at speeds that grow from next to nothing."""
    speeds = reach.speed * np.geomspace(0.01, 0.4, 5)
    return _course(t, _levels(t, np.stack([speeds, -speeds], axis=1).ravel(), np.ones(10)), reach)


def micro_reversals(t: Floats, reach: Reach) -> Floats:
    """Ramps forth and back over distances that grow from a few encoder counts to hundredths of the range."""
    count = 16
    distance = np.geomspace(max(reach.finest, 5e-4 * reach.travel), 0.04 * reach.travel, count)
    pace = distance / (float(t[-1] - t[0]) / count)
    return _course(t, _levels(t, pace * np.where(np.arange(count) % 2, -1.0, 1.0), np.ones(count)), reach)


def dwells(t: Floats, reach: Reach) -> Floats:
    """Short moves after rests that grow from a moment to a fifth of the time."""
    rests = np.geomspace(0.01, 0.2, 6) * float(t[-1] - t[0])
    move = (float(t[-1] - t[0]) - rests.sum()) / 6.0
    speed = min(0.3 * reach.speed, 0.4 * reach.travel / move)
    signs = np.where(np.arange(6) % 2, -1.0, 1.0)
    speeds = np.stack([np.zeros(6), signs * speed], axis=1).ravel()
    return _course(t, _levels(t, speeds, np.stack([rests, np.full(6, move)], axis=1).ravel()), reach)


def sweeps(t: Floats, reach: Reach) -> Floats:
    """Constant speed over the whole range, forth and back, slow and fast."""
    half = 0.5 * float(t[-1] - t[0])
    slow = 0.65 * half
    speeds = np.array([reach.travel / slow, -reach.travel / slow])
    quick = min(0.8 * reach.speed, reach.travel / (half - slow))
    return _course(t, _levels(t, [*speeds, quick, -quick], [slow, slow, half - slow, half - slow]), reach)


def quick_reversals(t: Floats, reach: Reach) -> Floats:
    """Reversals as sharp as the arm was seen to make, at a growing pace."""
    count = 24
    lengths = np.geomspace(2.0, 0.5, count)
    signs = np.where(np.arange(count) % 2, -1.0, 1.0)
    longest = lengths.max() / lengths.sum() * float(t[-1] - t[0])
    speed = min(0.5 * reach.speed, reach.travel / longest)
    return _course(t, _levels(t, signs * speed, lengths), reach)


def chirp(t: Floats, reach: Reach) -> Floats:
    """Sine whose frequency rises to the end of the band at a constant peak speed."""
    span, low = float(t[-1] - t[0]), 0.3
    rate = np.log(max(reach.band / low, 1.5)) / span
    pace = low * np.exp(rate * (t - t[0]))
    phase = 2.0 * np.pi * (pace - low) / rate
    peak = min(0.7 * reach.speed, reach.acceleration / (2.0 * np.pi * reach.band), np.pi * low * reach.travel)
    return _placed(_faded(t) * peak / (2.0 * np.pi * pace) * np.sin(phase), reach)


def multisine(t: Floats, reach: Reach) -> Floats:
    """Sines over the whole band, equal in speed, with Schroeder's phases against high peaks (Schroeder 1970)."""
    count = 12
    base = 1.0 / float(t[-1] - t[0])
    frequency = base * np.unique(np.round(np.geomspace(0.3, reach.band, count) / base))
    number = np.arange(len(frequency))
    phase = -np.pi * number * (number - 1) / len(frequency)
    course = np.sin(np.outer(t - t[0], 2.0 * np.pi * frequency) + phase) @ (1.0 / (2.0 * np.pi * frequency))
    course *= _faded(t)
    h = float(t[1] - t[0])
    speed = np.abs(np.gradient(course, h)).max()
    acceleration = np.abs(np.gradient(np.gradient(course, h), h)).max()
    return _placed(course * min(0.9 * reach.speed / speed, 1.2 * reach.acceleration / acceleration), reach)


def _faded(t: Floats) -> Floats:
    """Return a window (N,) that rises from 0 at the start and falls to 0 at the end, smooth to second order."""
    u = np.clip(np.minimum(t - t[0], t[-1] - t), 0.0, 1.0)
    return np.asarray(u**3 * (10.0 - 15.0 * u + 6.0 * u**2))


Maker = Callable[[Floats, Reach], Floats]

KINDS: dict[str, Maker] = {
    "slow ramp reversals": slow_reversals,
    "reversals of growing, at first microscopic, amplitude": micro_reversals,
    "short moves after ever longer rests": dwells,
    "constant-velocity sweeps over the range": sweeps,
    "quick reversals": quick_reversals,
    "a chirp": chirp,
    "a multisine": multisine,
}


@dataclass(frozen=True)
class Motion:
    """A motion of the arm: its ``kind``, the joints (indices) that move, and how large it is of what they can do."""

    kind: str
    joints: tuple[int, ...]
    size: float = 1.0

    def course(self, t: Floats, reach: Sequence[Reach]) -> Floats:
        """Return the positions (N, n), rad, at uniform times ``t`` (N,), s; the other joints hold mid-range."""
        columns = []
        for j, one in enumerate(reach):
            whole = KINDS[self.kind](t, one) if j in self.joints else np.full_like(t, one.centre)
            columns.append(one.centre + self.size * (whole - one.centre))
        return np.stack(columns, axis=1)

    def words(self, arm: Arm) -> str:
        """Return the motion in words."""
        if len(self.joints) == arm.n:
            return f"{self.kind}, {'all joints together' if arm.n > 1 else f'at {arm.names[0]}'}"
        return f"{self.kind}, at {' and '.join(arm.names[j] for j in self.joints)} alone"


def family(reach: Sequence[Reach], joints: Sequence[int]) -> tuple[Motion, ...]:
    """Return every kind of motion: each of ``joints`` alone, the others still, and all together, but for still ones."""
    able = tuple(j for j, one in enumerate(reach) if not one.still)
    places = dict.fromkeys([*((j,) for j in joints if j in able), able])
    return tuple(Motion(kind, place) for place in places if place for kind in KINDS)
