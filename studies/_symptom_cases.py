"""One effect hidden in one joint: what the re-tuned model leaves of its recordings, and what the effect's law takes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from stribeck.arm import Arm, Friction, Joint, Tolerance
from stribeck.effects.registry import laws
from stribeck.gap.fitted.model import Model, fit_model, retune, weights_of
from stribeck.gap.records.prepare import Prepared, prepare
from stribeck.gap.search.screen import screen
from stribeck.model.effect import Effect
from stribeck.model.layout import Placed
from stribeck.run import Run
from stribeck.withheld.arms import misinformed
from stribeck.withheld.excitation import programme
from stribeck.withheld.injections import Injection
from stribeck.withheld.recorder import default_gains, record
from stribeck.withheld.severity import severity

RATE, NOISE, SECONDS = 500.0, 2e-5, 8.0
KINDS = ("slow reversals", "multisine", "point to point", "speed stairs", "micro steps")
SURE = Tolerance(0.01, 0.03)  # of the data sheet, and what it is off by: little is left for re-tuning to hide
FRICTION = Friction(3.5, 1.4, 1.0, 0.06)
JOINT = Joint("A", "revolute", 0.35, 4.0, (0.12, 0.0), 0.08, 0.15, FRICTION, FRICTION, 80.0, 5e-5)
ARM = Arm("one vertical joint", (9.81, 0.0), (JOINT,), sample_time=1.0 / RATE, tolerance=SURE)
FLOOR = np.full(1, 0.01)  # N m
SEED = 6  # of each effect's strength, phase and place


@dataclass(frozen=True)
class Case:
    """Recordings of the arm as it is and with the effect, and the models fitted to them; None for a direct effect."""

    bare: Prepared
    runs: Prepared
    without: Model
    retuned: Model
    named: Model | None


def arm_for(effect: Effect) -> Arm:
    """Return the true arm, without falling friction where that is what the effect adds."""
    if effect.applies(ARM, 0):
        return ARM
    friction = replace(FRICTION, C1=0.0)
    return replace(ARM, joints=(replace(JOINT, friction=friction, backward=friction),))


def case_of(effect: Effect) -> Case:
    """Record one joint with the effect hidden in it, and fit it: re-tuned, and with the family's law that fits best."""
    true = arm_for(effect)
    nominal, motions, lab = _laboratory(true)
    rng = np.random.default_rng(SEED)
    hidden = Injection(effect.name, "A", severity(effect.name, true, "A", motions, "clear", rng, lab["gains"]))
    runs = prepare(nominal, *_twice(record(true, (hidden,), motions, **lab)))
    bare, without = _without(true)
    retuned = retune(runs, FLOOR)
    return Case(bare, runs, without, retuned, None if effect.direct else _named(effect, runs, retuned))


@cache
def _laboratory(true: Arm) -> tuple[Arm, tuple, dict]:
    nominal = replace(misinformed(true, np.random.default_rng(3), SURE.inertial, SURE.friction), tolerance=SURE)
    gains = default_gains(nominal, 3.0)
    motions = programme(nominal, np.random.default_rng(1), KINDS, SECONDS)
    lab = {"rate": RATE, "noise": NOISE, "gains": gains, "model": nominal, "seed": 5, "channels": ("dq",)}
    return nominal, motions, lab


@cache
def _without(true: Arm) -> tuple[Prepared, Model]:
    nominal, motions, lab = _laboratory(true)
    bare = prepare(nominal, *_twice(record(true, (), motions, **lab)))
    return bare, retune(bare, FLOOR)


def _twice(runs: tuple[Run, ...]) -> tuple[tuple[Run, ...], tuple[Run, ...]]:
    """All runs are drawn, so that all are fitted; nothing is judged here."""
    return runs, runs[:1]


def _named(effect: Effect, runs: Prepared, retuned: Model) -> Model:
    weights = weights_of(retuned, runs, FLOOR)
    models = []
    for law in (law for law in laws().values() if law.name == effect.name):
        start = screen(runs, retuned, weights, law, 0).start
        models.append(fit_model(runs, [Placed(law, 0)], weights, retuned.fit, start, evaluations=40))
    best = min(models, key=lambda model: model.fit.misfit)
    weights = weights_of(best, runs, FLOOR)  # the re-tuned model's residual was the effect's
    start = dict(best.placed[0].values)
    return fit_model(runs, best.placed, weights, best.fit, start, evaluations=40)
