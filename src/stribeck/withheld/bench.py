"""The laboratory of a case: clock, encoders, controller and motions, drawn as laboratories differ."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stribeck.arm import Arm
from stribeck.withheld.recorder import Gains, default_gains

ALWAYS = ("slow reversals", "multisine")
OTHERS = ("point to point", "speed stairs", "via points", "sweep", "micro steps", "slow reversals", "multisine")
RATES = (100.0, 125.0, 200.0, 250.0, 500.0, 1000.0)  # Hz


@dataclass(frozen=True)
class Bench:
    """How a laboratory records: everything that is drawn apart from arm and effect.

    Attributes
    ----------
    rate : float
        Samples a second, Hz.
    bits : int
        Of the encoders, a turn.
    noise : float or tuple of float
        Standard deviation of the encoders' noise, of each joint where there are several, rad.
    bandwidth, damping, integral, forward : float, float, float, str
        Of the controller, see `default_gains`.
    velocity_filter : float
        Its time constant, s.
    duration : float
        Of each motion, s.
    kinds : tuple of str
        The motions, see `excitation.KINDS`.
    one_by_one : bool
        Whether only one joint moves at a time.
    channels : tuple of str
        What is recorded beside positions and commands.
    """

    rate: float
    bits: int
    noise: float | tuple[float, ...]
    bandwidth: float
    damping: float
    integral: float
    forward: str
    velocity_filter: float
    duration: float
    kinds: tuple[str, ...]
    one_by_one: bool
    channels: tuple[str, ...]

    def gains(self, model: Arm) -> Gains:
        """Return the controller's gains for the arm that the laboratory believes to have."""
        gains = default_gains(model, self.bandwidth, self.damping, self.integral, self.forward)
        return replace(gains, velocity_filter=self.velocity_filter)


def draw_bench(rng: np.random.Generator, arm: Arm, names: Sequence[str]) -> Bench:
    """Return a random laboratory for `arm` in which the effects `names` can show."""
    rate, bits = float(rng.choice(RATES)), int(rng.integers(14, 21))
    channels = [c for c, chance in (("dq", 0.3), ("q_ref", 0.5), ("tau_meas", 0.15)) if rng.random() < chance]
    if "velocity_filter" in names and "dq" not in channels:
        channels.append("dq")
    kinds = [*ALWAYS, *rng.choice(OTHERS, int(rng.integers(2, 5)), replace=False)]
    rng.shuffle(kinds)
    vertical = math.hypot(*arm.gravity) > 0.0
    return Bench(
        rate=rate,
        bits=bits,
        noise=2.0 * math.pi / 2**bits * float(rng.uniform(0.1, 0.6)),
        bandwidth=min(float(rng.uniform(1.5, 4.0)), rate / 50.0),
        damping=float(rng.uniform(0.6, 1.0)),
        integral=float(rng.choice([0.0, 0.15, 0.3])),
        forward=str(rng.choice(["gravity", "inertial"] if vertical else ["none", "inertial"])),
        velocity_filter=max(1.0 / rate, float(rng.uniform(0.003, 0.008)) * (2.0 if bits < 16 else 1.0)),
        duration=round(float(rng.uniform(8.0, 10.0)), 1),
        kinds=tuple(str(k) for k in kinds),
        one_by_one=bool(rng.random() < 0.15),
        channels=tuple(channels),
    )
