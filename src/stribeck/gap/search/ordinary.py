"""What every arm has some of: it belongs to what is re-tuned, and is told of, but is no cause of a gap.

Any drive is a millisecond late; any contact gives way by up to ten micrometres before it slides; no drive is free of
offset and cogging by one and a half per cent of its torque, of the latter as far as it does not stand three noise
floors out; no friction is even by four; any motor that pulls twice as hard as usual loses two of them; friction that is
seen through samples trails the speed by up to two of these; no encoder is homed to better than a degree, nor a centre
of mass known to lie so, and none reads truer than to 40 seconds of arc. Where a search finds so little, the model is
re-tuned with it, and the search is made anew from there.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace

import numpy as np

from stribeck.arm import Arm
from stribeck.gap.fitted.model import Model, finite, fit_model, retune, weights_of
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.records.usual import no_more_than_any
from stribeck.gap.search.gates import needed
from stribeck.gap.search.rank import rank
from stribeck.gap.search.step import Step, last_model
from stribeck.model.layout import Placed
from stribeck.model.scale import Scale


def is_ordinary(place: Placed, scales: Sequence[Scale]) -> bool:
    """Return whether an effect with its fitted values is no more than every arm has."""
    return place.effect.ordinary(place.values, scales[place.joint])


def ordinary(steps: Sequence[Step], scales: Sequence[Scale]) -> tuple[Placed, ...]:
    """Return what a search took of what every arm has, with its values beside everything else that was taken."""
    return tuple(place for place in last_model(steps).placed[len(steps[0].base.placed) :] if is_ordinary(place, scales))


def retuned_with(
    prepared: Prepared, floor: np.ndarray, base: Model, stated: int, steps: Sequence[Step], seed: int
) -> Iterator[Model]:
    """Yield bases re-tuned with what a search took of what every arm has: with what may stand beside it, and without.

    None that holds more than every arm has without the others that were taken: it would stand in for what hides it.
    How often a wave repeats is held as it was found beside these: without them it would leap to another pitch.

    Parameters
    ----------
    prepared : Prepared
    floor : array (n,)
        Noise floor, N m rms.
    base : Model
        From which the search started.
    stated : int
        Number of effects that are the arm file's own.
    steps : sequence of Step
        Of the search.
    seed : int
        Of the bootstrap.
    """
    common = ordinary(steps, prepared.scales)
    beside = _beside(steps, prepared.scales)
    for found in ((*common, *beside), common)[not beside :]:
        steady = [replace(place, held=_pitches(place)) for place in found]
        again = retune(prepared, floor, (*base.placed, *steady), known=last_model(steps).fit)
        again = _needed_of(prepared, steps[-1].floor, again, len(base.placed) + len(common), seed)
        if all(is_ordinary(place, prepared.scales) for place in again.placed[stated:]):
            yield again
        if len(again.placed) == len(base.placed) + len(common):
            return


def _pitches(place: Placed) -> frozenset[str]:
    return frozenset(parameter.name for parameter in place.effect.parameters if parameter.pitch)


def _needed_of(prepared: Prepared, floor: np.ndarray, model: Model, kept: int, seed: int) -> Model:
    """Return a model without those effects after the first, ``kept`` ones that nothing asks for beside the others."""
    weights = weights_of(model, prepared, floor)
    for place in model.placed[kept:]:
        rest = [other for other in model.placed if other.key != place.key]
        without = fit_model(prepared, rest, weights, model.fit)
        if finite(without) and not needed(rank(prepared, [without, model], floor, seed)):
            model = without
    return model


def _beside(steps: Sequence[Step], scales: Sequence[Scale]) -> tuple[Placed, ...]:
    """Return what else every arm has that might have been taken in the last step, and is not the same in disguise."""
    step = steps[-1]
    same = step.ranking.twins()
    others = (step.rivals[k - 1].placed[-1] for k in step.passing if k not in same)
    return tuple(place for place in others if is_ordinary(place, scales))


def told_ordinary(base: Model, stated: Collection[Placed], arm: Arm) -> list[str]:
    """Return a note on what re-tuning took in beside the effects that the arm file has ``stated``."""
    own = {place.key for place in stated}
    return [
        f"{arm.names[place.joint]}: {no_more_than_any(place, arm)}; re-tuning took it in"
        for place in base.placed
        if place.key not in own
    ]


def told_unnamed(steps: Sequence[Step], scales: Sequence[Scale], arm: Arm, *, beside: bool = False) -> list[str]:
    """Return a note on what a search took beside others that is no more than every arm has there.

    ``beside`` what is named it is delivered as well.
    """
    said = "in the corrected model, and not named" if beside else "not named"
    return [f"{arm.names[place.joint]}: {no_more_than_any(place, arm)}; {said}" for place in ordinary(steps, scales)]
