"""The fitted candidates of a step: how they rank, which may be taken, and which others to fit as well."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from stribeck.effects.registry import registry
from stribeck.gap.fitted.model import Model
from stribeck.gap.fitted.white import noise_of_best
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.search.candidates import Trial
from stribeck.gap.search.families import HALF, best_of_each
from stribeck.gap.search.gates import earns_its_place
from stribeck.gap.search.random_torque import random_joints
from stribeck.gap.search.rank import ALIKE, Ranking, rank
from stribeck.model.layout import Placed

MUCH = 2.0  # noise floors rms that a step leaves: what its first look was blind to is looked for as well


class Judged(NamedTuple):
    """The rivals of a step, how they rank, which may be taken, and the noise floor (n,) by which they are judged."""

    rivals: list[Model]
    ranking: Ranking
    passing: tuple[int, ...]
    floor: np.ndarray


def judge(
    prepared: Prepared,
    floor: np.ndarray,
    seed: int,
    base: Model,
    fitted: Sequence[Model | None],
    taken: Sequence[Placed],
    before: np.ndarray | None,
) -> Judged:
    """Return what fitted trials come to beside their base, in the registry's order.

    Parameters
    ----------
    prepared : Prepared
    floor : array (n,)
        What encoder noise and filters leave, N m rms.
    seed : int
        Of the bootstrap.
    base : Model
    fitted : sequence of Model or None
        The base with one more effect each; None where its fit ran away.
    taken : sequence of Placed
        Effects that earlier steps have taken.
    before : array (n,) or None
        The noise floor of the step before, N m rms.
    """
    order = list(registry())
    rivals = best_of_each(fitted, prepared, floor)
    rivals.sort(key=lambda model: (order.index(model.placed[-1].effect.name), model.placed[-1].joint))
    floor = noise_of_best(floor, [base, *rivals], prepared, before)
    ranking = rank(prepared, [base, *rivals], floor, seed)
    random = random_joints(prepared, base, floor, seed)
    passing = tuple(
        k for k in ranking.order if earns_its_place(ranking, k, rivals[k - 1], prepared.scales, taken, random)
    )
    if passing:
        ranking = replace(ranking, best=passing[0])
    return Judged(rivals, ranking, passing, floor)


def as_hopeful(tried: Sequence[Trial], kept: Collection[tuple[str, int]], judged: Judged) -> list[Trial]:
    """Return the trials that promised about as much as what would be taken, but were not fitted: others promised more.

    They may be the same in disguise, and belong to its class.
    """
    if not judged.passing:
        return []
    best = judged.rivals[judged.ranking.best - 1].placed[-1].key
    promise = next((trial.promise for trial in tried if trial.key == best), np.inf)
    alike = (trial for trial in tried if ALIKE * promise < trial.promise < promise / ALIKE)
    return [trial for trial in alike if trial.key not in kept]


def further_laws(tried: Sequence[Trial], fitted: Collection[tuple[str, str, int]], judged: Judged) -> list[Trial]:
    """Return the trials of further laws of what would be taken, where that leaves much at its joint.

    Of laws that nearly explain a large gap the promises hardly differ; what they leave does.

    Parameters
    ----------
    tried : sequence of Trial
    fitted : collection of (str, str, int)
        Law keys of the trials that were fitted.
    judged : Judged
        What these came to.
    """
    if not judged.passing:
        return []
    best = judged.rivals[judged.ranking.best - 1].placed[-1]
    if judged.ranking.power[judged.ranking.best, best.joint] < MUCH**2:
        return []
    own = [trial for trial in tried if trial.key == best.key]
    promise = max((trial.promise for trial in own if trial.law_key in fitted), default=np.inf)
    return [trial for trial in own if trial.law_key not in fitted and trial.promise > HALF * promise]
