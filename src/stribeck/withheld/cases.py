"""Blind cases: an arm, its wrong data sheet, and recordings with an effect that is known only here."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from stribeck.arm import Arm
from stribeck.errors import StribeckError
from stribeck.run import Run
from stribeck.withheld.arms import misinformed, random_arm
from stribeck.withheld.excitation import programme
from stribeck.withheld.injections import KNOWN, Injection
from stribeck.withheld.measure import relative_gap
from stribeck.withheld.motions import Motion
from stribeck.withheld.plant import Diverged
from stribeck.withheld.recorder import Gains, default_gains, record
from stribeck.withheld.severity import severity

ALWAYS = ("slow reversals", "multisine")
OTHERS = ("point to point", "speed stairs", "via points", "sweep", "micro steps", "slow reversals", "multisine")
RATES = (100.0, 125.0, 200.0, 250.0, 500.0, 1000.0)  # Hz
TRIES = 4  # with ever softer gains, where the arm swings up


@dataclass(frozen=True)
class Case:
    """One blind case.

    Attributes
    ----------
    arm_nominal, arm_true : Arm
        What the diagnoser is given, and what recorded.
    runs : tuple of Run
        The recordings, in the order in which they were made.
    truth : dict
        ``effects`` (effect, joint, parameters), ``level``, ``worth`` (share of each joint's torque), ``known``
        (whether a library may hold the effects) and ``laboratory``; can be written as JSON.
    """

    arm_nominal: Arm
    arm_true: Arm
    runs: tuple[Run, ...]
    truth: dict[str, Any]


@dataclass(frozen=True)
class Bench:
    """How a laboratory records: everything that is drawn apart from arm and effect."""

    rate: float
    bits: int
    noise: float
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


def make_case(
    seed: int,
    effect: str | Sequence[str] | None,
    level: str = "clear",
    n_joints: int = 2,
    *,
    joint: str | None = None,
    vertical: bool | None = None,
) -> Case:
    """Record a case in which everything but the effect's name and level is drawn from `seed`.

    Parameters
    ----------
    seed : int
        The same seed gives the same case.
    effect : str, sequence of str, or None
        Of `injections.KNOWN` or `injections.UNKNOWN`; None hides nothing.
    level : str
        ``clear``, ``medium`` or ``weak``, see `severity`.
    n_joints : int
        1 to 4.
    joint : str or None
        Where the effect sits; drawn where None.
    vertical : bool or None
        Whether gravity acts; drawn where None.
    """
    rng = np.random.default_rng([seed, 2026])
    names = (effect,) if isinstance(effect, str) else tuple(effect or ())
    upright = bool(rng.random() < 0.5) if vertical is None else vertical
    if vertical is None:  # an offset shows only under gravity, a torque limit only where gravity does not need it all
        upright = (upright or "encoder_offset" in names) and "torque_saturation" not in names
    true = random_arm(rng, n_joints, upright)
    bench = _bench(rng, true, names)
    count = 2.0 * math.pi / 2**bench.bits
    true = replace(
        true,
        sample_time=1.0 / bench.rate,
        joints=tuple(replace(j, encoder_resolution=count) for j in true.joints),
    )
    places = [joint or _place(rng, name, true) for name in names]
    for name, place in zip(names, places, strict=True):
        if name == "negative_damping":
            true = _without_stribeck(true, place)
    nominal = misinformed(true, rng, float(rng.choice([0.02, 0.05, 0.1])), float(rng.choice([0.1, 0.2, 0.3])))
    motions = programme(nominal, rng, bench.kinds, bench.duration, bench.one_by_one)
    effects = _sized(names, places, level, true, motions, bench.gains(nominal), int(rng.integers(2**31)))
    bench, runs = _steady(true, nominal, effects, motions, bench, seed)
    return Case(nominal, true, runs, _truth(seed, level, true, effects, motions, bench, nominal))


def _bench(rng: np.random.Generator, arm: Arm, names: Sequence[str]) -> Bench:
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


def _place(rng: np.random.Generator, name: str, arm: Arm) -> str:
    drawn = str(rng.choice(arm.names))
    return {"payload": arm.names[-1], "gravity_tilt": arm.names[0], "base_flexibility": arm.names[0]}.get(name, drawn)


def _without_stribeck(arm: Arm, place: str) -> Arm:
    """Friction of joint `place` without its falling part, so that negative damping is news."""
    joints = [
        replace(j, friction=replace(j.friction, C1=0.0), backward=replace(j.backward, C1=0.0)) if j.name == place else j
        for j in arm.joints
    ]
    return replace(arm, joints=tuple(joints))


def _sized(
    names: Sequence[str],
    places: Sequence[str],
    level: str,
    arm: Arm,
    motions: Sequence[Motion],
    gains: Gains,
    seed: int,
) -> tuple[Injection, ...]:
    """Return the effects at their level; each is sized alone, on motions in which its joint moves."""
    effects = []
    for number, (name, place) in enumerate(zip(names, places, strict=True)):
        rng = np.random.default_rng([seed, number])
        effects.append(Injection(name, place, severity(name, arm, place, _telling(motions), level, rng, gains)))
    return tuple(effects)


def _telling(motions: Sequence[Motion]) -> list[Motion]:
    """Return three motions that size the effect: one of each kind that is always there, and one more."""
    first = [next(i for i, motion in enumerate(motions) if motion.name == kind) for kind in ALWAYS]
    other = next(i for i in range(len(motions)) if i not in first)
    return [motions[i] for i in sorted([*first, other])]


def _steady(
    true: Arm, nominal: Arm, effects: Sequence[Injection], motions: Sequence[Motion], bench: Bench, seed: int
) -> tuple[Bench, tuple[Run, ...]]:
    """Record; where the arm swings up or sits at its torque limit, do as anybody would: turn the gains down."""
    for _ in range(TRIES):
        try:
            runs = record(
                true, effects, motions, rate=bench.rate, noise=bench.noise, gains=bench.gains(nominal), model=nominal,
                channels=bench.channels, seed=seed,
            )  # fmt: skip
        except Diverged:
            runs = ()
        if runs and all(_calm(run, true) for run in runs):
            return bench, runs
        bench = replace(bench, bandwidth=0.65 * bench.bandwidth)
    if not runs:
        raise StribeckError("the arm cannot be held with this effect", f"seed {seed}", "use a weaker level")
    return bench, runs


def _calm(run: Run, arm: Arm) -> bool:
    limits = np.array([joint.torque_limit or math.inf for joint in arm.joints])
    return bool(np.all(np.mean(np.abs(run.tau) >= 0.999 * limits, axis=0) < 0.02))


def _truth(
    seed: int, level: str, arm: Arm, effects: Sequence[Injection], motions: Sequence[Motion], bench: Bench, nominal: Arm
) -> dict[str, Any]:
    worth = relative_gap(arm, effects, _telling(motions), bench.gains(nominal))
    return {
        "seed": seed,
        "level": level if effects else None,
        "known": all(e.effect in KNOWN for e in effects),
        "effects": [{"effect": e.effect, "joint": e.joint, "parameters": dict(e.params)} for e in effects],
        "worth": dict(zip(arm.names, (round(float(w), 4) for w in worth), strict=True)),
        "laboratory": asdict(bench),
    }
