"""Recordings that tell too little: a few short, small motions of an arm with one hidden effect."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stribeck.arm import Arm
from stribeck.effects.registry import registry
from stribeck.run import Run
from stribeck.withheld import KNOWN
from stribeck.withheld.arms import misinformed, random_arm
from stribeck.withheld.bench import ALWAYS, Bench, draw_bench
from stribeck.withheld.cases import place_of
from stribeck.withheld.excitation import programme
from stribeck.withheld.hide import Plot, hide
from stribeck.withheld.injections import Injection
from stribeck.withheld.motions import Array, Curve, Motion

OWN_STREAM = 2029  # of random numbers
DURATION = 4.0  # s, of each poor motion
SIZE = (0.25, 0.8)  # of what an engineer would ask of the arm
RATES = (200.0, 250.0)  # Hz
KINDS = ("slow reversals", "multisine", "point to point", "speed stairs", "via points", "sweep", "micro steps")
TELLING = (*ALWAYS, "via points")  # motions of full size, on which the effect is sized
SENSED = frozenset(name for name, effect in registry().items() if effect.direct)
# Coloured noise has no law; the plant's history is slower than any run here; the data sheets have falling friction
LEFT_OUT = SENSED | {"input_disturbance", "history", "negative_damping"}
EFFECTS = tuple(name for name in KNOWN if name not in LEFT_OUT)


@dataclass(frozen=True)
class Poor:
    """A case: what the diagnoser is given, what recorded, where, and with what hidden."""

    seed: int
    nominal: Arm
    true: Arm
    runs: tuple[Run, ...]
    hidden: Injection
    strength: float
    bench: Bench

    def words(self) -> dict[str, Any]:
        """Return what is hidden, as JSON has it."""
        return {"seed": self.seed, "effect": self.hidden.effect, "joint": self.hidden.joint, "strength": self.strength}


def poor_case(seed: int, effect: str, joints: tuple[int, ...] = (1, 2)) -> Poor:
    """Return a case in which all but the effect's name is drawn from a seed.

    The effect takes 5 to 25 % of the torque on motions of full size; what is recorded is two of those kinds, 4 s each,
    at a quarter to four fifths of the size. ``joints`` are the numbers of joints that are drawn from.
    """
    rng = np.random.default_rng([seed, OWN_STREAM])
    upright = effect != "torque_saturation" and (bool(rng.random() < 0.6) or effect in ("encoder_offset", "payload"))
    true = random_arm(rng, int(rng.choice(joints)), upright)
    bench = draw_bench(rng, true, (effect,))
    kinds = tuple(str(kind) for kind in rng.choice(KINDS, 2, replace=False))
    bench = replace(bench, rate=float(rng.choice(RATES)), bits=int(rng.integers(16, 21)), duration=DURATION,
                    kinds=kinds, one_by_one=False, channels=())  # fmt: skip
    count = 2.0 * np.pi / 2**bench.bits
    bench = replace(bench, noise=count * float(rng.uniform(0.1, 0.6)))
    true = replace(true, sample_time=1.0 / bench.rate,
                   joints=tuple(replace(j, encoder_resolution=float(f"{count:.4g}")) for j in true.joints))  # fmt: skip
    place = place_of(rng, effect, true)
    nominal = misinformed(true, rng, float(rng.choice([0.02, 0.05, 0.1])), float(rng.choice([0.1, 0.2, 0.3])))
    telling = programme(nominal, rng, TELLING, 6.0)
    size = float(rng.uniform(*SIZE))
    motions = [_smaller(motion, size) for motion in programme(nominal, rng, kinds, DURATION)]
    plot = Plot((effect,), (place,), str(rng.choice(["clear", "medium"])), int(rng.integers(2**31)))
    case = hide(true, nominal, motions, telling, bench, plot, seed)
    (truth,) = case.truth["effects"]
    hidden = Injection(effect, place, truth["parameters"])
    return Poor(seed, nominal, true, case.runs, hidden, truth["strength"], Bench(**case.truth["laboratory"]))


def _smaller(motion: Motion, size: float) -> Motion:
    return replace(motion, curves=tuple(_around_start(curve, size) for curve in motion.curves))


def _around_start(curve: Curve, size: float) -> Curve:
    def smaller(t: Array) -> tuple[Array, Array, Array]:
        q, dq, ddq = curve(t)
        first = curve(np.zeros(1))[0]
        return first + size * (q - first), size * dq, size * ddq

    return smaller
