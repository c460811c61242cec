"""How strong a hidden effect is: its torque against the noise floor of the recording that has to show it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from scipy.signal import butter, sosfiltfilt

from stribeck.arm import Arm
from stribeck.run import Run
from stribeck.withheld.bench import Bench
from stribeck.withheld.injections import Injection
from stribeck.withheld.measure import STEP, residual_torque
from stribeck.withheld.motions import Motion
from stribeck.withheld.plant import Array
from stribeck.withheld.recorder import record

# Hz; encoder noise, differentiated twice, rises steeply, and effects differ in where they show
BANDS = (4.0, 8.0, 15.0)


def strengths(
    arm: Arm, nominal: Arm, effects: Sequence[Injection], motions: Sequence[Motion], bench: Bench, seed: int = 0
) -> tuple[float, ...]:
    """Return for each effect its torque over the noise floor, rms over motions, in the joint and band where it is most.

    The torque is what the true arm without the effect leaves unexplained in a recording with it and without
    noise, less what the same computation leaves without the effect; the floor is what it leaves in a recording of this
    laboratory, encoders and noise included, without the effect. Position and command pass the same low pass before, of
    4, 8 or 15 Hz; all `motions` count alike, each effect is alone. A velocity filter changes no torque: its strength
    is the change of the recorded velocity over that signal's own noise, 0 where velocity is not recorded.

    Parameters
    ----------
    arm, nominal : Arm
        The true arm, and what the controller believes of it.
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

    def clean(hidden: Iterable[Injection]) -> Array:
        return _left(arm, record(arm, hidden, motions, resolution=0.0, **lab), bench.rate)

    floor = _left(arm, record(arm, (), motions, noise=bench.noise, **lab), bench.rate)
    nothing = clean(())

    def share(effect: Injection) -> float:
        if effect.effect == "velocity_filter":
            return _velocity_share(arm, effect, motions, bench, lab) if "dq" in bench.channels else 0.0
        part = np.maximum(clean([effect]) - nothing, 0.0) / np.maximum(floor, 1e-24)
        return float(np.max(np.mean(part, axis=1)))

    return tuple(math.sqrt(share(effect)) for effect in effects)


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


def _left(arm: Arm, runs: Sequence[Run], rate: float) -> Array:
    """Return the mean square (bands, runs, n) of the torque that the arm leaves unexplained, (N m)^2."""
    bands = []
    for cut in BANDS:
        sos = butter(2, cut, fs=rate, output="sos")
        left = [
            residual_torque(arm, sosfiltfilt(sos, run.q, axis=0), sosfiltfilt(sos, run.tau, axis=0), rate, cut)[0]
            for run in runs
        ]
        bands.append([np.mean(part**2, axis=0) for part in left])
    return np.array(bands)
