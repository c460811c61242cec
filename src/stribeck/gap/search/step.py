"""One step of the search."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stribeck.gap.fitted.model import Model
from stribeck.gap.search.rank import Ranking
from stribeck.gap.search.setting import Known


@dataclass(frozen=True)
class LookAlike:
    """A law of no library that may stand behind what a step took: in words, and the chance that it does better."""

    says: str
    chance: float


@dataclass(frozen=True)
class Step:
    """One step of the search: the base, its rivals, how they rank, and which of them may be taken, best first.

    Attributes
    ----------
    base : Model
        From which the step starts.
    rivals : tuple of Model
        The base with one more effect each, fitted.
    ranking : Ranking
        Of the base, then the rivals.
    passing : tuple of int
        Places in the ranking of those that may be taken, best first.
    screened_out : tuple of (str, int)
        Name and joint of each candidate that promised too little to be fitted, here or when the step was first made.
    floor : array (n,)
        The noise floor by which they were judged, N m rms.
    worth : Ranking or None
        Of a step that took an effect, once the search has ended: the last model without that effect, and whole. An
        effect that the gap of another one hid shows there what it is worth.
    together : Ranking or None
        Of a step that took an effect which others took at other joints, once the search has ended: the last model
        without it at any of them, where it is more than every arm has, and whole.
    as_good : tuple of Model
        Of a step that took an effect, once the search has ended: the whole model with that effect, then those with a
        rival in its place that these data cannot tell from it. Empty where there is none.
    look_alike : LookAlike or None
        Of a step that took an effect, once the search has ended: the decoy that comes nearest to it.
    """

    base: Model
    rivals: tuple[Model, ...]
    ranking: Ranking
    passing: tuple[int, ...]
    screened_out: tuple[tuple[str, int], ...]
    floor: np.ndarray
    worth: Ranking | None = None
    together: Ranking | None = None
    as_good: tuple[Model, ...] = ()
    look_alike: LookAlike | None = None

    @property
    def taken(self) -> bool:
        """Whether the best rival was taken."""
        return bool(self.passing)

    @property
    def best(self) -> Model | None:
        """The best rival."""
        return self.rivals[self.ranking.best - 1] if self.ranking.best else None

    @property
    def ends(self) -> Known:
        """The values at which the fits of the rivals ended, by law and joint."""
        last = (model.placed[-1] for model in self.rivals)
        return {(place.effect.name, place.effect.law, place.joint): dict(place.values) for place in last}


def last_model(steps: Sequence[Step]) -> Model:
    """Return the model with everything that was taken."""
    last = steps[-1]
    return last.best if last.taken and last.best is not None else last.base


def alike(step: Step, steps: Sequence[Step]) -> list[int]:
    """Return the rivals that a step's data cannot tell from what it took, that first, without what is there as well.

    Two gaps of a size, at two joints, look alike to the step that takes one of them before the other.
    """
    own, r = step.rivals[step.ranking.best - 1].placed[-1].key, step.ranking
    there = {place.key for place in last_model(steps).placed} - {own}
    same = [k for k in r.twins() if k != r.best and step.rivals[k - 1].placed[-1].key not in there]
    return [r.best, *sorted(same, key=lambda k: -float(r.overall[k]))]
