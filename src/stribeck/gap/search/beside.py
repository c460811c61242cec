"""What each effect that was taken is worth beside all others, and which of them is needless or misleading then."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from joblib import delayed

from stribeck.effects.placing import stated_effects
from stribeck.gap.fitted.model import Model, cost_by, finite, fit_model, weights_of
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.search.families import left_by
from stribeck.gap.search.forward import HARDLY
from stribeck.gap.search.gates import LEAST_FURTHER, LEAST_GAIN, needed
from stribeck.gap.search.ordinary import is_ordinary
from stribeck.gap.search.presence import evidence, presence
from stribeck.gap.search.rank import rank, saved
from stribeck.gap.search.step import Step, last_model
from stribeck.identify.problem import Weights
from stribeck.model.layout import Placed

MUCH_LEFT = 2.5  # of the noise floor's power, beside an effect that alone was taken: another one may be the true one
NEARLY = 0.6  # of what it gains, in logarithms, that the other one gains
WEIGHING = 40  # evaluations of the last model without one of its effects
AS_WELL = 1.0  # cost more, at which an effect does alone what it did with another one
STANDS_IN = 1 / 3  # of what an effect gained, in logarithms: two of which each alone does the rest are one, twice


def without_each(prepared: Prepared, steps: Sequence[Step], pool: Any) -> list[Model]:
    """Return, for each effect that was taken, the last model fitted anew without it.

    And without what every arm has some of, where that would grow to more in its place; but not where it does all that
    the two did. The search has seen a model without the last one: of the two the better, for a play that is fitted anew
    may end elsewhere.
    """
    final, own, count = last_model(steps), len(steps[0].base.placed), sum(step.taken for step in steps)
    if count < 2:
        return [steps[0].base] * count
    floor = steps[-1].floor
    weights = weights_of(final, prepared, floor)
    rests = [(*final.placed[:i], *final.placed[i + 1 :]) for i in range(own, own + count)]
    stated = {place.key for place in stated_effects(prepared.arm)}
    little = {place.key for place in final.placed if is_ordinary(place, prepared.scales)} - stated
    enough = cost_by(final, weights) + AS_WELL
    *others, last = pool(delayed(_kept_little)(prepared, rest, weights, little, enough) for rest in rests)
    seen = steps[count - 1].base
    return [*others, min((seen, last), key=lambda model: left_by(model.whole, floor) if finite(model) else np.inf)]


def _kept_little(
    prepared: Prepared, placed: Sequence[Placed], weights: Weights, little: Collection[tuple[str, int]], enough: float
) -> Model:
    """Return a model with some effects, without those of the ``little`` ones that grow to more than every arm has.

    At a cost that is ``enough`` all of them stay.
    """
    model = fit_model(prepared, placed, weights, None, evaluations=WEIGHING)
    kept = [place for place in model.placed if place.key not in little or is_ordinary(place, prepared.scales)]
    if len(kept) == len(model.placed) or model.fit.cost < enough:
        return model
    return fit_model(prepared, kept, weights, model.fit, evaluations=WEIGHING)


def weighed(prepared: Prepared, steps: Sequence[Step], without: Sequence[Model], seed: int) -> tuple[Step, ...]:
    """Return the steps with what each effect that was taken is worth beside all others.

    Parameters
    ----------
    prepared : Prepared
    steps : sequence of Step
        Of the search.
    without : sequence of Model
        As of :func:`without_each`.
    seed : int
        Of the bootstrap.
    """
    final, floor = last_model(steps), steps[-1].floor
    found = [rank(prepared, [model, final], floor, seed) if finite(model) else None for model in without]
    return tuple(replace(step, worth=found[i]) if i < len(found) else step for i, step in enumerate(steps))


def with_together(prepared: Prepared, steps: Sequence[Step], pool: Any, seed: int) -> tuple[Step, ...]:
    """Return the steps; those that took one effect at several joints with what it is worth at all of them.

    At each it may do much of the other's work: neither is worth much then, though it is surely there at one of them.
    """
    final, floor, own = last_model(steps), steps[-1].floor, len(steps[0].base.placed)
    base, found = final.placed[:own], final.placed[own:]
    names = [name for name, count in Counter(place.effect.name for place in found).items() if count > 1]
    if not names:
        return tuple(steps)
    weights = weights_of(final, prepared, floor)
    kept = [[p for p in found if p.effect.name != name or is_ordinary(p, prepared.scales)] for name in names]
    rests = [(*base, *others) for others in kept]
    models = pool(delayed(fit_model)(prepared, rest, weights, None, evaluations=WEIGHING) for rest in rests)
    worth = {
        name: rank(prepared, [model, final], floor, seed)
        for name, model in zip(names, models, strict=True)
        if finite(model)
    }
    return tuple(
        replace(step, together=worth.get(step.best.placed[-1].effect.name) if step.taken and step.best else None)
        for step in steps
    )


class Idle(NamedTuple):
    """What is needless beside others, and the part of the squared residual that a search may leave more without it."""

    key: tuple[str, int]
    cost: float


def idle(steps: Sequence[Step]) -> Idle | None:
    """Return an effect that the later ones have made needless, or None.

    Or one that is hardly there beside them, and takes less than a further effect must: it shares with a later one what
    that would do by itself, as a delay that was taken first does with the lag that is there.
    """
    for step in [step for step in steps if step.taken][:-1]:
        if step.worth is None or step.best is None:
            continue
        place = step.best.placed[-1]
        if not needed(step.worth):
            return Idle(place.key, LEAST_GAIN)
        if step.worth.overall[1] < LEAST_FURTHER and presence(evidence(step)) < HARDLY:
            return Idle(place.key, LEAST_FURTHER)
    return None


def stands_in(steps: Sequence[Step]) -> bool:
    """Return whether what the last of some steps took does the work of an earlier one: each alone does most of it.

    What a cable leaves of its own law a wave over position takes, and then most of the cable's as well. Beside each
    other neither is worth much, though one of them is surely there.
    """
    last = steps[-1]
    if last.worth is None:
        return False
    mine = saved(last.worth.overall[1])
    return any(
        step.worth is not None
        and max(mine, saved(step.worth.overall[1])) < STANDS_IN * saved(step.ranking.overall[step.ranking.best])
        for step in steps[:-1]
    )


def misleading(steps: Sequence[Step]) -> tuple[str, int] | None:
    """Return the one effect that was taken where it leaves much, nothing helps it, and another came near it; or None.

    A lag that follows a delay in part leaves what hides the payload beside it.
    """
    taken = [step for step in steps if step.taken]
    if len(taken) != 1 or steps[-1].taken or taken[0].best is None:
        return None
    ranking, worth = taken[0].ranking, taken[0].worth
    left = ranking.power[ranking.best] if worth is None else worth.power[1]
    near = NEARLY * saved(ranking.overall[ranking.best])
    names = {
        taken[0].rivals[k - 1].placed[-1].effect.name for k in taken[0].passing if saved(ranking.overall[k]) > near
    }
    place = taken[0].best.placed[-1]
    return place.key if left.max() > MUCH_LEFT and names - {place.effect.name} else None
