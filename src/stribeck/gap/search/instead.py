"""Rivals in the place of an effect that was taken, once all are there: one may do better, or as well."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from joblib import delayed

from stribeck.gap.fitted.model import Model, finite, fit_model, weights_of
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.search.candidates import candidates
from stribeck.gap.search.gates import LEAST_GAIN
from stribeck.gap.search.rank import rank
from stribeck.gap.search.step import Step, last_model
from stribeck.model.layout import Placed

RIVALS = 2  # of a step that are tried in the place of what it took
SURELY = 0.95  # probability by which they must be the better ones
EVALUATIONS = 40


@dataclass(frozen=True)
class Instead:
    """What a step took, ``place``, and the ``model`` of the whole search with a rival of that step in its place."""

    place: Placed
    model: Model


def instead(
    prepared: Prepared, steps: Sequence[Step], pool: Any, leave_out: Sequence[str] = (), gone: Sequence[Placed] = ()
) -> list[Instead]:
    """Return the last model with the most promising rivals of each step in the place of what it took.

    Of one effect alone, those that came all but as near: by the weights of what it leaves, not of the whole gap. And of
    what is ``gone``, a needless effect that no step has seen: it may do as well in the place of any.

    Parameters
    ----------
    prepared : Prepared
    steps : sequence of Step
        Of the search.
    pool : Pool
    leave_out : sequence of str
        Effects that are no candidates.
    gone : sequence of Placed
        What an earlier search took, and this one was to do without.
    """
    taken = [step for step in steps if step.taken]
    if not taken:
        return []
    final, own = last_model(steps), len(steps[0].base.placed)
    pairs = []
    for i, step in enumerate(taken, own):
        rest = (*final.placed[:i], *final.placed[i + 1 :])
        possible = [
            (effect.name, effect.law, joint)
            for effect, joint in candidates(prepared.arm, rest, leave_out)
            if (effect.name, joint) != final.placed[i].key
        ]
        r = step.ranking
        near = r.order if len(taken) > 1 else set(r.near())
        rivals = [step.rivals[k - 1].placed[-1] for k in r.order if k in near and r.overall[k] > LEAST_GAIN]
        seen, more = (
            [rival for rival in some if (rival.effect.name, rival.effect.law, rival.joint) in possible]
            for some in (rivals, gone)
        )
        pairs += [(final.placed[i], rival) for rival in (*seen[:RIVALS], *more)]
    return in_its_place(prepared, steps, pairs, pool)


def in_its_place(
    prepared: Prepared, steps: Sequence[Step], pairs: Sequence[tuple[Placed, Placed]], pool: Any
) -> list[Instead]:
    """Return the last model of a search with other effects, each in the place of one that was taken, fitted from there.

    Parameters
    ----------
    prepared : Prepared
    steps : sequence of Step
    pairs : sequence of (Placed, Placed)
        What was taken, and the other one with values to start from.
    pool : Pool
    """
    if not pairs:
        return []
    final = last_model(steps)
    weights = weights_of(final, prepared, steps[-1].floor)
    fits = []
    for place, rival in pairs:
        placed = (*(other for other in final.placed if other is not place), Placed(rival.effect, rival.joint))
        fits.append(delayed(fit_model)(prepared, placed, weights, final.fit, rival.values, evaluations=EVALUATIONS))
    found = zip(pairs, pool(fits), strict=True)
    return [Instead(place, model) for (place, _), model in found if finite(model)]


def outdone(prepared: Prepared, steps: Sequence[Step], others: Sequence[Instead], seed: int) -> tuple[str, int] | None:
    """Return an effect in whose place a rival does better now that the others are there, or None.

    A law with several parameters may be taken first because it follows two effects at once, neither of them its own.
    """
    if not others:
        return None
    ranking = rank(prepared, [last_model(steps), *(other.model for other in others)], steps[-1].floor, seed)
    place = others[int(np.argmax(ranking.probability[1:]))].place
    return place.key if ranking.probability[0] < 1.0 - SURELY else None


def with_as_good(
    prepared: Prepared, steps: Sequence[Step], without: Sequence[Model], others: Sequence[Instead], seed: int
) -> tuple[Step, ...]:
    """Return the steps with the rivals that do as well in the place of what each took, now that the others are there.

    An encoder's offset is no tilt of gravity while a payload is hidden; once that is known, a pendulum has them alike.

    Parameters
    ----------
    prepared : Prepared
    steps : sequence of Step
        Of the search.
    without : sequence of Model
        As of :func:`stribeck.gap.search.beside.without_each`.
    others : sequence of Instead
        As of :func:`instead`.
    seed : int
        Of the bootstrap.
    """
    if not others:
        return tuple(steps)
    final, floor, own = last_model(steps), steps[-1].floor, len(steps[0].base.placed)
    weights = weights_of(final, prepared, floor)
    found = list(steps)
    for i, (step, rest) in enumerate(zip(steps, without, strict=False)):  # the last step may have taken nothing
        place = final.placed[own + i]
        rivals = [other.model for other in others if other.place.key == place.key]
        if not rivals or not finite(rest):
            continue
        ranking = rank(prepared, [rest, final, *rivals], floor, seed)
        same = _one_of_each([rivals[k - 2] for k in ranking.twins() if k > 1])
        if 1 in ranking.twins() and same:
            placed = (*final.placed[: own + i], *final.placed[own + i + 1 :], Placed(place.effect, place.joint))
            again = fit_model(prepared, placed, weights, final.fit, dict(place.values), evaluations=EVALUATIONS)
            found[i] = replace(step, as_good=(again, *same))
    return tuple(found)


def _one_of_each(models: Sequence[Model]) -> list[Model]:
    """Return of models that end in the same effect the one that costs least."""
    best: dict[tuple[str, int], Model] = {}
    for model in models:
        key = model.placed[-1].key
        best[key] = min(best.get(key, model), model, key=lambda one: one.fit.cost)
    return list(best.values())
