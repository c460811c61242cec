"""One lateness of all joints, or a lag of each: drives of one make lag alike, and a search goes joint by joint."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from joblib import delayed

from stribeck.effects.registry import laws
from stribeck.gap.fitted.model import Model, finite, fit_model, weights_of
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.search.instead import EVALUATIONS
from stribeck.gap.search.rank import rank
from stribeck.gap.search.step import Step, last_model
from stribeck.model.effect import Effect
from stribeck.model.layout import Placed, rival


def with_lags(
    prepared: Prepared,
    steps: Sequence[Step],
    without: Sequence[Model],
    pool: Any,
    seed: int,
    leave_out: Sequence[str] = (),
) -> tuple[Step, ...]:
    """Return the steps; where one took a lateness of all joints, with what does as well as a lag of each.

    Parameters
    ----------
    prepared : Prepared
    steps : sequence of Step
        Of the search.
    without : sequence of Model
        As of :func:`stribeck.gap.search.beside.without_each`.
    pool : Pool
    seed : int
        Of the bootstrap.
    leave_out : sequence of str
        Effects that are no candidates.
    """
    final, floor, own, found = last_model(steps), steps[-1].floor, len(steps[0].base.placed), list(steps)
    for i, (step, rest) in enumerate(zip(steps, without, strict=False)):  # the last step may have taken nothing
        place = final.placed[own + i]
        if not (place.effect.everywhere and place.effect.delays and place.values["time"] > 0.0 and finite(rest)):
            continue
        others = (*final.placed[: own + i], *final.placed[own + i + 1 :])
        lags = [effect for effect in laws().values() if _lags(effect) and effect.name not in leave_out]
        placed = [(*others, place), *(_at_each(effect, place, prepared, others) for effect in lags)]
        weights = weights_of(final, prepared, floor)
        fits = (delayed(fit_model)(prepared, one, weights, final.fit, evaluations=EVALUATIONS) for one in placed if one)
        again, *rivals = pool(fits)
        rivals = [model for model in rivals if finite(model)]
        if not (finite(again) and rivals):
            continue
        same = [rivals[k - 2] for k in rank(prepared, [rest, again, *rivals], floor, seed).twins() if k > 1]
        if same:
            found[i] = replace(step, as_good=(*(step.as_good or (again,)), same[0]))
    return tuple(found)


def _lags(effect: Effect) -> bool:
    """Return whether a law of one constant makes a drive late, and by more than a delay."""
    late = effect.channel == "actuator" and "late" in effect.kin and effect.delays is None
    return late and len(effect.parameters) == 1


def _at_each(effect: Effect, place: Placed, prepared: Prepared, others: Sequence[Placed]) -> tuple[Placed, ...]:
    """Return the other effects with a law at each joint, as late as ``place``; nothing where one has its place."""
    joints = place.joints(prepared.arm.n)
    taken = {(other.effect.name, j) for other in others for j in other.joints(prepared.arm.n)}
    fits = all(effect.applies(prepared.arm, j) for j in joints)
    if not fits or any((effect.name, j) in taken or rival(effect, j, others) for j in joints):
        return ()
    (time,) = (parameter.name for parameter in effect.parameters)
    return (*others, *(Placed(effect, j, {time: place.values["time"]}) for j in joints))
