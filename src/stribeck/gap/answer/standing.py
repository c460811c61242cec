"""Which causes of a finished search stand, and the models from the re-tuned one to the one that is delivered."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from stribeck.gap.answer.closing import Closing
from stribeck.gap.answer.motion import Motions
from stribeck.gap.answer.verdict import causes_of, named_of, with_idle
from stribeck.gap.fitted.model import Model, fit_model, weights_of
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.result import Cause
from stribeck.gap.search.gates import LEAST_GAIN
from stribeck.gap.search.ordinary import is_ordinary
from stribeck.gap.search.step import Step
from stribeck.model.layout import Placed


@dataclass(frozen=True)
class Standing:
    """What stands of a search.

    Its ``causes`` and what is ``left_over`` of their chances; the ``chain`` of models from the re-tuned one to that
    with all that are named, one effect more each; and effects with which the arm ``strayed``, by how many times as far.
    """

    causes: list[Cause]
    left_over: float
    chain: list[Model]
    strayed: dict[str, float]


def standing(
    prepared: Prepared,
    steps: Sequence[Step],
    models: Sequence[Model],
    floor: np.ndarray,
    closing: Closing,
    motions: Motions,
) -> Standing:
    """Return what stands in the model that would be delivered.

    An effect that is idle there, or with which the arm goes astray, is at half, and the model is made without it.

    Parameters
    ----------
    prepared : Prepared
    steps : sequence of Step
        Of a finished search.
    models : sequence of Model
        Its models, from the re-tuned one on, one effect more each.
    floor : array (n,)
        Noise floor that its models were fitted by, N m rms.
    closing : Closing
    motions : Motions
    """
    causes, left_over = causes_of(steps, prepared.arm.names, prepared.scales)
    strayed: dict[str, float] = {}
    while True:
        named = named_of(causes)
        chain = chain_of(prepared, models, floor, [cause for cause in causes if cause.effect in named])
        gone = [] if len(chain) == len(models) else _idle(named, chain, closing)  # the search has judged its own
        if not gone:
            strayed |= {effect: times for effect, times in motions.strayed(chain).items() if effect in named}
            gone = [effect for effect in strayed if effect in named]
        if not gone:
            return Standing(causes, left_over, chain, strayed)
        causes, left_over = with_idle(causes, gone)


def chain_of(prepared: Prepared, models: Sequence[Model], floor: np.ndarray, named: Sequence[Cause]) -> list[Model]:
    """Return the models from the re-tuned one to that with all named causes, one effect more each.

    Each at the joints that its cause tells of; and beside them what was taken that is no more than every arm has.
    Those of the search, as far as it took the same.
    """
    base, last = models[0], models[-1]
    first, names = len(base.placed), prepared.arm.names
    told = {cause.effect: cause.joints for cause in named}
    kept = [
        place
        for place in last.placed[first:]
        if names[place.joint] in told.get(place.effect.name, ()) or (told and is_ordinary(place, prepared.scales))
    ]
    if first + len(kept) == len(last.placed):
        return list(models)
    chain = [base]
    for i in range(len(kept)):
        known = models[i + 1]
        if _laws(known.placed[first:]) == _laws(kept[: i + 1]):
            chain.append(known)
            continue
        placed = (*base.placed, *kept[: i + 1])
        model, start = chain[-1], last.fit  # what an effect that is missing bends leads astray
        for evaluations in (40, 20, 20):  # weights of what is left before, then of what is left after
            model = fit_model(prepared, placed, weights_of(model, prepared, floor), start, evaluations=evaluations)
            start = model.fit
        chain.append(model)
    return chain


def gained(effect: str, chain: Sequence[Model]) -> float:
    """Return the largest part of the squared residual that a model of a chain gains by an effect, at any joint."""
    pairs = [(before, after) for before, after in pairwise(chain) if after.placed[-1].effect.name == effect]
    powers = [[np.mean(model.held**2, axis=0) for model in pair] for pair in pairs]
    gains = [1.0 - after[before > 0.0] / before[before > 0.0] for before, after in powers]  # no brake held the joint
    return max((float(np.max(gain)) for gain in gains if len(gain)), default=-np.inf)


def _idle(named: Sequence[str], chain: Sequence[Model], closing: Closing) -> list[str]:
    """Return the named effects that hardly close anything without those that are not: they stood beside them alone.

    So little that the search would not have taken them.
    """
    return [
        effect
        for effect in named
        if closing.by_effect(effect, chain).value <= 0.0 or gained(effect, chain) < LEAST_GAIN
    ]


def _laws(placed: Sequence[Placed]) -> list[tuple[str, int, str]]:
    return [(*place.key, place.effect.law) for place in placed]
