"""How strong a hidden effect is: its torque against the noise floor of the recording that has to show it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.signal import sosfiltfilt

from stribeck.arm import Arm
from stribeck.run import Run
from stribeck.withheld.bench import Bench
from stribeck.withheld.injections import Injection
from stribeck.withheld.measure import STEP, derived, driven, low_pass, unexplained
from stribeck.withheld.motions import Motion
from stribeck.withheld.plant import Array
from stribeck.withheld.recorder import record
from stribeck.withheld.retune import Knob, knobs, left_over

# Hz; encoder noise, differentiated twice, rises steeply, and effects differ in where they show
BANDS = (4.0, 8.0, 15.0)
RESTING = 0.01  # squared floor of a joint in any motion over that of all: one that sticks shows none of its own


class Strength(NamedTuple):
    """Torque of an effect over the noise floor: all of it, and what re-tuning the nominal arm leaves of it."""

    plain: float
    left: float


def strengths(
    arm: Arm, nominal: Arm, effects: Sequence[Injection], motions: Sequence[Motion], bench: Bench, seed: int = 0
) -> tuple[Strength, ...]:
    """Return for each effect its torque over the noise floor, rms over motions, in the joint and band where it is most.

    The torque is what the true arm without the effect leaves unexplained in a recording with it and without
    noise, less what the same computation leaves without the effect; the floor is what it leaves in a recording of this
    laboratory, encoders and noise included, without the effect. Position and command pass the same low pass before, of
    4, 8 or 15 Hz; all `motions` count alike, each effect is alone. What is left is the same torque after the nominal
    arm is re-tuned to this recording within its tolerances (:mod:`stribeck.withheld.retune`), by as much as the floor
    allows; re-tuning for one joint may cost another some, but never counts for more than the effect itself. A
    velocity filter changes no torque: its strength is the change of the recorded velocity over that signal's own
    noise, 0 where velocity is not recorded, and nothing takes it up.

    Parameters
    ----------
    arm, nominal : Arm
        The true arm, and what the controller believes of it, with its tolerances.
    effects : sequence of Injection
        Their strengths are in this order.
    motions : sequence of Motion
        What is recorded.
    bench : Bench
        The laboratory.
    seed : int
        Of the encoders' noise.

    Raises
    ------
    Diverged
        Where the controller cannot hold the arm.
    """
    gains = bench.gains(nominal)
    lab: dict[str, Any] = {"rate": bench.rate, "gains": gains, "model": nominal, "seed": seed, "step": STEP}

    def clean(hidden: Iterable[Injection]) -> tuple[Run, ...]:
        return record(arm, hidden, motions, resolution=0.0, **lab)

    free = [driven(motion, arm.n) for motion in motions]

    def bands(runs: Sequence[Run]) -> list[_Band]:
        return [_Band.of(runs, free, bench.rate, cut) for cut in BANDS]

    floor = _resting(_all(arm, bands(record(arm, (), motions, noise=bench.noise, **lab))))
    turnable = knobs(nominal, arm)

    def both(runs: Sequence[Run]) -> tuple[Array, Array]:
        seen = bands(runs)
        left = [_retuned(arm, band, turnable, floor[i]) for i, band in enumerate(seen)]
        return _all(arm, seen), np.array(left)

    nothing = both(clean(()))

    def measured(effect: Injection) -> Strength:
        if effect.effect == "velocity_filter":
            share = _velocity_share(arm, effect, motions, bench, lab) if "dq" in bench.channels else 0.0
            return Strength(math.sqrt(share), math.sqrt(share))
        plain, after = (_share(part - bare, floor) for part, bare in zip(both(clean([effect])), nothing, strict=True))
        return Strength(plain, min(plain, after))

    return tuple(measured(effect) for effect in effects)


def _share(part: Array, floor: Array) -> float:
    """Return the root of mean squares (bands, runs, n) over their floor, of the joint and band where it is most."""
    return math.sqrt(float(np.max(np.mean(np.maximum(part, 0.0) / floor, axis=1))))


def _resting(floor: Array) -> Array:
    """Return floors (bands, runs, n), that of a joint which sticks through a motion as a part of its others'."""
    return np.asarray(np.maximum(floor, np.maximum(RESTING * np.mean(floor, axis=1, keepdims=True), 1e-24)))


def _velocity_share(
    arm: Arm, effect: Injection, motions: Sequence[Motion], bench: Bench, lab: Mapping[str, Any]
) -> float:
    """Return the mean square change of the recorded velocity over that of its noise, where it is largest."""

    def velocity(hidden: Iterable[Injection], **noise: Any) -> list[Array]:
        runs = record(arm, hidden, motions, channels=("dq",), **noise, **lab)
        return [np.asarray(run.dq) for run in runs]

    silent = velocity((), resolution=0.0)
    late, noisy = velocity([effect], resolution=0.0), velocity((), noise=bench.noise)
    change = [np.mean((a - b) ** 2, axis=0) for a, b in zip(late, silent, strict=True)]
    floor = [np.mean((a - b) ** 2, axis=0) for a, b in zip(noisy, silent, strict=True)]
    return float(np.max(np.mean(np.array(change) / np.maximum(floor, 1e-24), axis=0)))


@dataclass(frozen=True)
class _Band:
    """Recordings of one rate, below `cut`, Hz: motion and command (N, n) of each run, and its driven joints (n,)."""

    parts: tuple[tuple[tuple[Array, Array, Array], Array, Array], ...]
    rate: float
    cut: float

    @classmethod
    def of(cls, runs: Sequence[Run], free: Sequence[Array], rate: float, cut: float) -> _Band:
        sos = low_pass(rate, cut)
        low = [(sosfiltfilt(sos, run.q, axis=0), sosfiltfilt(sos, run.tau, axis=0)) for run in runs]
        return cls(tuple((derived(q, rate), tau, own) for (q, tau), own in zip(low, free, strict=True)), rate, cut)

    def unexplained(self, arm: Arm) -> list[Array]:
        """Return the torque (M, n) of each run that the arm leaves unexplained, N m."""
        return [unexplained(arm, motion, tau, self.rate, self.cut) * own for motion, tau, own in self.parts]


def _all(arm: Arm, bands: Sequence[_Band]) -> Array:
    """Return the mean square (bands, runs, n) of the torque that the arm leaves unexplained, (N m)^2."""
    return np.array([_squared(band.unexplained(arm)) for band in bands])


def _retuned(arm: Arm, band: _Band, turnable: Sequence[Knob], floor: Array) -> Array:
    """Return the mean square (runs, n) of what re-tuning leaves, (N m)^2; `floor` (runs, n) is that of this band.

    Below `cut` a second holds 2 `cut` independent samples, which share the information of all.
    """
    lengths = [len(part) for part in band.unexplained(arm)]
    weight = np.repeat(min(1.0, 2.0 * band.cut / band.rate) / floor, lengths, axis=0)
    left = left_over(turnable, arm, lambda other: np.concatenate(band.unexplained(other)), weight)
    return _squared(np.split(left, np.cumsum(lengths)[:-1]))


def _squared(parts: Sequence[Array]) -> Array:
    return np.array([np.mean(part**2, axis=0) for part in parts])
