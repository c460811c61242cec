"""Hide effects in an arm and record it: what every case has in common, whichever arm and motions it is made of."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from stribeck.arm import Arm
from stribeck.errors import StribeckError
from stribeck.run import Run
from stribeck.withheld.bench import Bench
from stribeck.withheld.injections import KNOWN, Injection
from stribeck.withheld.measure import relative_gap
from stribeck.withheld.motions import Motion
from stribeck.withheld.plant import Diverged
from stribeck.withheld.recorder import record
from stribeck.withheld.severity import severity
from stribeck.withheld.stage import stage_of
from stribeck.withheld.strength import strengths

TRIES = 4  # with ever softer gains, where the arm swings up
SHAKEN = (0.01, 0.04)  # share of the rms torque, of a disturbance that is no effect of the arm


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
        ``effects`` (effect, joint, parameters, strength: torque over the noise floor, strength_left: what re-tuning
        the nominal arm leaves of it), ``disturbances`` (the same, of what is no effect of the arm), ``level``,
        ``worth`` (share of each joint's torque), ``known`` (whether a library may hold the effects) and
        ``laboratory``; can be written as JSON.
    """

    arm_nominal: Arm
    arm_true: Arm
    runs: tuple[Run, ...]
    truth: dict[str, Any]


@dataclass(frozen=True)
class Plot:
    """What is hidden: effects `names` in the joints `places`, at a `level`, sized with `seed`; ``disturbed`` or not."""

    names: tuple[str, ...]
    places: tuple[str, ...]
    level: str
    seed: int
    disturbed: bool = False


def hide(
    true: Arm, nominal: Arm, motions: Sequence[Motion], telling: Sequence[Motion], bench: Bench, plot: Plot, seed: int
) -> Case:
    """Size the effects, record all motions, and note the truth.

    Parameters
    ----------
    true, nominal : Arm
        What is recorded, and what laboratory and diagnoser believe of it.
    motions, telling : sequence of Motion
        What is recorded, and the part of it on which effects are sized and measured.
    bench : Bench
        The laboratory.
    plot : Plot
        What to hide.
    seed : int
        Of the recorder's noise.

    Raises
    ------
    StribeckError
        Where the arm cannot be held with these effects.
    """
    effects = _sized(plot, true, telling, bench, nominal)
    disturbances = _shaken(true, telling, plot.seed) if plot.disturbed else ()
    hidden = (*effects, *disturbances)
    bench, runs = _steady(true, nominal, hidden, motions, bench, seed)
    strong = strengths(true, nominal, hidden, telling, bench, seed)
    rows = [
        {"effect": e.effect, "joint": e.joint, "parameters": dict(e.params), "strength": float(f"{s.plain:.4g}"),
         "strength_left": float(f"{s.left:.4g}")}
        for e, s in zip(hidden, strong, strict=True)
    ]  # fmt: skip
    worth = relative_gap(true, effects, telling, bench.gains(nominal))
    truth = {
        "seed": seed,
        "level": plot.level if effects else None,
        "known": all(e.effect in KNOWN for e in effects),
        "effects": rows[: len(effects)],
        "disturbances": rows[len(effects) :],
        "worth": dict(zip(true.names, (round(float(w), 4) for w in worth), strict=True)),
        "laboratory": asdict(bench),
    }
    return Case(nominal, true, runs, truth)


def _sized(plot: Plot, arm: Arm, telling: Sequence[Motion], bench: Bench, nominal: Arm) -> tuple[Injection, ...]:
    """Return the effects at their level; each is sized alone, on motions in which its joint moves."""

    def left(effect: Injection) -> float:
        return strengths(arm, nominal, [effect], telling, bench, plot.seed)[0].left

    effects, gains = [], bench.gains(nominal)
    for number, (name, place) in enumerate(zip(plot.names, plot.places, strict=True)):
        rng, k = np.random.default_rng([plot.seed, number]), arm.names.index(place)
        own = [motion for motion in telling if k not in motion.held]
        effects.append(Injection(name, place, severity(name, arm, place, own, plot.level, rng, gains, left)))
    return tuple(effects)


def _shaken(arm: Arm, telling: Sequence[Motion], seed: int) -> tuple[Injection, ...]:
    """Return coloured torque noise in one joint."""
    rng = np.random.default_rng([seed, 7])
    driven = [k for k in range(arm.n) if any(k not in motion.held for motion in telling)]
    k = driven[int(rng.integers(len(driven)))]
    size = stage_of(arm, k, telling, rng).torque * float(rng.uniform(*SHAKEN))
    params = {"noise": float(f"{size:.4g}"), "amplitude": 0.0, "bandwidth": round(float(rng.uniform(1.0, 8.0)), 2)}
    return (Injection("input_disturbance", arm.names[k], params),)


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
