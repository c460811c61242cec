"""Fits from all starts of a law: a few steps from each of them tell which are followed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from joblib import delayed

from stribeck.gap.fitted.model import Model, finite, fit_model
from stribeck.gap.records.prepare import Prepared
from stribeck.identify.problem import Weights
from stribeck.model.effect import Effect
from stribeck.model.layout import Placed

GLANCE, FOLLOWED, FAR = 6, 2, 40  # evaluations from every start, those that are followed, and how far
NEAR = 0.75  # of the base's cost, below which those steps must come: one that does most of a gap is seen to


def from_every_start(
    prepared: Prepared, base: Model, weights: Weights, wanted: Sequence[tuple[Effect, int]], pool: Callable[..., Any]
) -> list[Model | None]:
    """Return the best model of each law at a joint, from all of its starts; None where no few steps do a good part.

    Parameters
    ----------
    prepared : Prepared
    base : Model
        To which each law is added.
    weights : Weights
        Of the rows of the fit runs.
    wanted : sequence of (Effect, int)
        Laws, each with the index of its joint.
    pool : Pool
    """
    found = ends(prepared, base, [weights] * len(wanted), wanted, pool, NEAR * base.fit.cost)
    return [next(iter(of), None) for of in found]


def ends(
    prepared: Prepared,
    base: Model,
    weights: Sequence[Weights],
    wanted: Sequence[tuple[Effect, int]],
    pool: Callable[..., Any],
    most: float = np.inf,
) -> list[list[Model]]:
    """Return where each law's starts lead that a few steps bring below the cost ``most``, the best one first.

    The starts of all laws are fitted side by side, for one law may take as long as all others. A compliance is screened
    without its observer, and lightly damped it then rings on beside a record that does not know when it began: such
    starts seem hopeless there, and the way from a damped one ends damped.

    Parameters
    ----------
    prepared : Prepared
    base : Model
        To which each law is added.
    weights : sequence of Weights
        Of the rows of the fit runs, for each law.
    wanted : sequence of (Effect, int)
        Laws, each with the index of its joint.
    pool : Pool
    most : float
        Cost, in units of information.
    """
    starts = [(k, start) for k, (e, j) in enumerate(wanted) for start in e.starts(prepared.scales[j])]
    glances = pool(delayed(_glance)(prepared, base, weights[k], *wanted[k], start) for k, start in starts)
    ways = _of_each(len(wanted), [k for k, _ in starts], glances)
    near = [
        (k, model)
        for k, of in enumerate(ways)
        for model in [way for way in _meant_first(of, prepared) if way.fit.cost < most][:FOLLOWED]
    ]
    far = pool(delayed(_far)(prepared, weights[k], model) for k, model in near)
    return [_meant_first(of, prepared) for of in _of_each(len(wanted), [k for k, _ in near], far)]


def meant(model: Model, prepared: Prepared) -> bool:
    """Whether the values of a model's last effect can be meant."""
    place = model.placed[-1]
    return place.effect.plausible(place.values, prepared.scales[place.joint])


def _of_each(count: int, whose: Sequence[int], models: Sequence[Model]) -> list[list[Model]]:
    return [[model for k, model in zip(whose, models, strict=True) if k == law] for law in range(count)]


def _glance(
    prepared: Prepared, base: Model, weights: Weights, effect: Effect, joint: int, start: Mapping[str, float]
) -> Model:
    placed = (*base.placed, Placed(effect, joint))
    return fit_model(prepared, placed, weights, base.fit, dict(start), evaluations=GLANCE)


def _far(prepared: Prepared, weights: Weights, model: Model) -> Model:
    return fit_model(prepared, model.placed, weights, model.fit, evaluations=FAR)


def _meant_first(models: Sequence[Model], prepared: Prepared) -> list[Model]:
    """Return the models that have not run away, by their cost; those with values that can be meant first."""
    return sorted(filter(finite, models), key=lambda model: (not meant(model, prepared), model.fit.cost))
