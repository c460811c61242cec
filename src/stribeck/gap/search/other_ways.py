"""Other effects to begin with, where those that were taken leave much, or one of them has become needless."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stribeck.effects.registry import registry
from stribeck.gap.fitted.model import Model
from stribeck.gap.search.families import left_by
from stribeck.gap.search.forward import FAR_LESS, YIELDING, forward
from stribeck.gap.search.gates import LEAST_GAIN, holds
from stribeck.gap.search.rank import saved
from stribeck.gap.search.setting import Setting
from stribeck.gap.search.step import Step, last_model

MUCH = 4.0  # noise floors rms at a joint, that what was taken leaves
PART = 0.5  # of what the first one gained, in logarithms, that another one gains to be begun with
MOST = 2  # others


def another_way(setting: Setting, base: Model, steps: tuple[Step, ...]) -> tuple[Step, ...]:
    """Return steps that begin with another effect and leave far less after two; else the same ones.

    What follows two effects at once, neither of them its own, may come first alone, and nothing helps it then: of a
    gain beside friction that goes with the load the latter takes most by a law that is not the true one. Not with a
    compliance, nor with one as the second: they take long.

    Parameters
    ----------
    setting : Setting
    base : Model
        From which the search started.
    steps : tuple of Step
        Of the search.
    """
    first, final = steps[0], last_model(steps)
    much = np.any(np.mean(final.whole**2, axis=0) > MUCH**2 * steps[-1].floor ** 2)
    if not first.taken or not much:
        return steps
    ranking, known, found = first.ranking, first.ends, steps
    least = left_by(final.whole, setting.floor) - FAR_LESS
    near = PART * saved(ranking.overall[ranking.best])
    firm = [k for k in first.passing if not isinstance(first.rivals[k - 1].placed[-1].effect, YIELDING)]
    others = [k for k in firm if k != ranking.best and saved(ranking.overall[k]) > near]
    compliances = tuple(name for name, effect in registry().items() if isinstance(effect, YIELDING))
    firmly = replace(setting, leave_out=(*setting.leave_out, *compliances))
    for k in others[:MOST]:
        setting.progress(f"again, {first.rivals[k - 1].placed[-1].effect.name} first")
        tried = forward(firmly, base, known, (_taking(first, k),), until=lambda model: True)
        left = left_by(last_model(tried).whole, setting.floor)
        if left < least:
            found, least = tried, left
    return steps if found is steps else forward(setting, base, known, found)


def passed_over(setting: Setting, base: Model, steps: tuple[Step, ...], needless: tuple[str, int]) -> tuple[Step, ...]:
    """Return steps that take at once what came after a needless effect, and go on from there; the same ones else.

    Half of two gaps may not hold on other runs, and something else that does comes first. That it has become needless
    says that what followed will do without it; a search that starts anew would stand before the same choice.

    Parameters
    ----------
    setting : Setting
        In which the needless effect is barred.
    base : Model
        From which the search started.
    steps : tuple of Step
        Of the search.
    needless : (str, int)
        Name and joint of what one of them took.
    """
    taken = [place.key for place in last_model(steps).placed[len(steps[0].base.placed) :]]
    i, scales = taken.index(needless), setting.prepared.scales
    step, places = steps[i], {k: model.placed[-1] for k, model in enumerate(steps[i].rivals, 1)}
    later = [k for k, place in places.items() if place.key in taken[i + 1 :] and holds(place, scales[place.joint])]
    best = max(later, key=lambda k: step.ranking.overall[k], default=0)
    if not best or step.ranking.overall[best] < LEAST_GAIN:
        return steps
    (gone,) = (k for k, place in places.items() if place.key == needless)
    return forward(setting, base, step.ends, (*steps[:i], _without(_taking(step, best), gone)))


def _taking(step: Step, k: int) -> Step:
    """Return a step that takes its k-th rival instead."""
    passing = (k, *(other for other in step.passing if other != k))
    return replace(step, ranking=replace(step.ranking, best=k), passing=passing)


def _without(step: Step, k: int) -> Step:
    """Return a step without its k-th rival: what gained more there is no equal of what is taken in its place."""
    rivals = tuple(model for place, model in enumerate(step.rivals, 1) if place != k)
    passing = tuple(other - (other > k) for other in step.passing if other != k)
    return replace(step, rivals=rivals, ranking=step.ranking.without(k), passing=passing)
