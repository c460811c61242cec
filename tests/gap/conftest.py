"""Runs by formula for the statistics, and one short recording of the independent plant for whole diagnoses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np

from stribeck.arm import Arm, Friction, Joint
from stribeck.gap.fitted.model import Model
from stribeck.gap.search.rank import Ranking
from stribeck.gap.search.step import Step
from stribeck.identify.conditioning import Conditioned, condition
from stribeck.identify.map_fit import Fit
from stribeck.model.layout import Placed
from stribeck.run import Run
from stribeck.withheld.arms import misinformed
from stribeck.withheld.excitation import programme
from stribeck.withheld.injections import Injection
from stribeck.withheld.recorder import default_gains, record

FRICTION = Friction(4.6, 1.65, 1.4, 0.06)
JOINT = Joint("A", "revolute", 0.35, 4.0, (0.17, 0.01), 0.06, 0.15, FRICTION, FRICTION, 80.0, 2e-5)
TRUE = Arm("one joint", (9.81, 0.0), (JOINT,), sample_time=0.004)
NOMINAL = misinformed(TRUE, np.random.default_rng(3), 0.03, 0.2)


def recorded(
    *effects: tuple[str, dict[str, float]], noise: float = 1e-5, channels: Sequence[str] = ()
) -> tuple[Run, ...]:
    """Four runs of a pendulum, 4 s each, with effects hidden in it; recorded once and frozen."""
    return _recorded(tuple((name, tuple(values.items())) for name, values in effects), noise, tuple(channels))


@cache
def _recorded(
    effects: tuple[tuple[str, tuple[tuple[str, float], ...]], ...], noise: float, channels: tuple[str, ...]
) -> tuple[Run, ...]:
    kinds = ("slow reversals", "multisine", "via points", "point to point")
    motions = programme(NOMINAL, np.random.default_rng(1), kinds, 4.0)
    hidden = [Injection(name, "A", dict(values)) for name, values in effects]
    gains = default_gains(NOMINAL, 3.0)
    return record(TRUE, hidden, motions, rate=250.0, noise=noise, gains=gains, model=NOMINAL, seed=5, channels=channels)


def sines(seconds: float, rate: float = 200.0, seed: int = 0, size: float = 1.0, name: str = "run") -> Run:
    """A joint on two sines of random phase, its torque noise."""
    t = np.arange(round(seconds * rate)) / rate
    rng = np.random.default_rng(seed)
    q = size * sum(np.sin(2 * np.pi * f * t + rng.uniform(0, 6)) for f in (0.4, 1.1))
    return Run(name, t, np.asarray(q)[:, None], rng.standard_normal((len(t), 1)))


def conditioned(seconds: Sequence[float], rate: float = 200.0) -> list[Conditioned]:
    return [condition(TRUE, sines(s, rate, i), 15.0, np.full(1, 1e-6)) for i, s in enumerate(seconds)]


def fitted(placed: Sequence[Placed], gap: np.ndarray) -> Model:
    """A model with these effects that leaves a gap (n,), N m rms; nothing was fitted."""
    none = np.zeros((0, len(gap)))
    fit = Fit((), np.zeros(0), np.zeros(0, dtype=int), none, none[..., None], 0.0, 0.0, "Solve_Succeeded", ())
    return Model(tuple(placed), fit, gap[None, :])


def ranked(t: float, overall: float, power: np.ndarray) -> Ranking:
    """A base and its one rival, which gains so much; ``power`` (2, n) is what each leaves, in floors."""
    zeros, loss = np.zeros(2), power[:, None, :]
    gain = np.array([[0.0, 0.0, 0.0], [overall, overall, overall]])
    sure = np.array([0.0, 1.0])
    return Ranking(
        sure, loss, gain, np.array([0.0, overall]), np.array([0.0, t]), sure, power, zeros, zeros, best=1, order=(1,)
    )


def taken_steps(
    placed: Sequence[Placed],
    removed: Sequence[float],
    *,
    gap: np.ndarray,
    floor: np.ndarray,
    candidates: Sequence[str] = (),
    left: float = 1.0,
) -> list[Step]:
    """The steps of a search that took these effects one after the other.

    ``removed`` is what each takes of the squared residual, and ``left`` what stays, in floors; ``gap`` (n,) what
    re-tuning leaves, N m rms.
    """
    tried = tuple((name, 0) for name in candidates)
    steps = []
    for k, size in enumerate(removed):
        power = np.repeat([[size + left], [left]], len(gap), axis=1)
        base, best = (fitted(placed[: k + i], gap) for i in (0, 1))
        steps.append(Step(base, (best,), ranked(12.0, 0.95, power), (1,), tried, floor))
    return steps


def with_effects(step: Step, base: Sequence[Placed], best: Sequence[Placed] | None = None) -> Step:
    """A step with other effects in its base, and in its one rival where they are given."""
    (rival,) = step.rivals
    rival = rival if best is None else replace(rival, placed=tuple(best))
    return replace(step, base=replace(step.base, placed=tuple(base)), rivals=(rival,))
