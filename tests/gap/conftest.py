"""Runs by formula for the statistics, and one short recording of the independent plant for whole diagnoses."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np

from stribeck.arm import Arm, Friction, Joint
from stribeck.identify.conditioning import Conditioned, condition
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


def taken_steps(
    placed: Sequence[Placed],
    removed: Sequence[float],
    *,
    gap: np.ndarray,
    floor: np.ndarray,
    candidates: Sequence[str] = (),
    left: float = 1.0,
) -> list[Any]:
    """The steps of a search that took these effects one after the other, as far as a verdict looks at them.

    ``removed`` is what each takes of the squared residual, and ``left`` what stays, in floors; ``gap`` (n,) what
    re-tuning leaves, N m rms.
    """
    steps: list[Any] = []
    for k, size in enumerate(removed):
        base, best = (SimpleNamespace(placed=tuple(placed[: k + i]), rms=lambda: gap) for i in (0, 1))
        power = np.array([[size + left] * 2, [left] * 2])
        ranking = SimpleNamespace(best=1, overall=[0.0, 0.95], t=[0.0, 12.0], power=power, twins=lambda: [1])
        tried = tuple((name, 0) for name in candidates)
        steps.append(
            SimpleNamespace(
                taken=True,
                base=base,
                best=best,
                rivals=(best,),
                ranking=ranking,
                worth=None,
                together=None,
                as_good=(),
                look_alike=None,
                screened_out=tried,
                floor=floor,
            )
        )
    return steps
