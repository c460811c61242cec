"""From the steps of a search to a verdict, the causes and their probabilities."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.special import expit

from stribeck.effects.registry import registry
from stribeck.gap.records.spread import Noise, noise_power
from stribeck.gap.result import Cause
from stribeck.gap.search.kin import FILLING, filling_in, simpler_than
from stribeck.gap.search.ordinary import is_ordinary
from stribeck.gap.search.presence import evidence, presence
from stribeck.gap.search.step import Step, alike, last_model
from stribeck.model.layout import Placed
from stribeck.model.scale import Scale

AT_FLOOR = 1.4  # residual over noise floor up to which nothing is left to explain
EXPLAINED = 0.9  # of the closable gap: from there on nothing is left to explain, either
# residual over noise floor up to which there is no gap, next to nothing of the torque and much of it: of 200 sealed
# cases without effect some were left with 1.3 to 1.7 floors where that was below SLIGHT of the torque, none above
SILENT_TO, SILENT_OF_MUCH = 1.6, 1.25
SLIGHT = 0.03
# of the chance of "unknown" where nothing was taken: so held 92 of 101 on sealed cases and on six plants that others
# wrote, and what came nearest was there five times
UNKNOWN_HELD = 0.9
MOST_SUSPECTS = 2
IN_TIME = 0.25  # of their mean, by which the delays of all joints may differ and still be one
ORDINARY = 0.1  # of the presence of what every arm has some of: it is there, and no cause to be named
IDLE = 0.5  # of the presence of what does not stand in the model that would be delivered
# of the chance of "none", where random torque is left: it may have a cause that counts, as in none of 600 sealed cases
FROM_OUTSIDE = 0.1
# probability of presence from which an effect is named; of 16 from 0.55 on, in 600 sealed cases and on three plants
# that others wrote, 7 were there
NAMED_OVER = 0.6
NONE_OVER = 0.5  # probability of nothing, from which there is no gap


def causes_of(steps: Sequence[Step], names: Sequence[str], scales: Sequence[Scale]) -> tuple[list[Cause], float]:
    """Return the causes that the taken steps name, without parameters, and the probability of ``unknown``."""
    taken = [step for step in steps if step.taken]
    gathered: dict[str, list[_Found]] = {}
    for step, fills in zip(taken, filling_in(taken, scales), strict=True):
        found = _found(step, steps, fills, scales)
        gathered.setdefault(found.place.effect.name, []).append(found)
    late = late_as_one(steps, len(names)) if taken else ()
    whole = sum(one.share for all_of_it in gathered.values() for one in all_of_it) or 1.0
    causes = []
    for effect, all_of_it in gathered.items():
        telling = [one for one in all_of_it if not one.ordinary] or all_of_it
        surest = max(one.presence for one in telling)
        sure = [one for one in telling if one.presence > NAMED_OVER]  # a joint is named as an effect is
        somewhere = min(one.together for one in telling)
        anywhere = not sure and len(telling) > 1 and somewhere > surest
        surest, telling = somewhere if anywhere else surest, sure or telling
        part = sum(one.share for one in all_of_it) / whole
        common = late if effect in late else ()
        equivalent = tuple(dict.fromkeys((*(name for one in telling for name in one.equivalent), *common)))
        at = {names[j]: (*one.equivalent, *common) for one in telling for j in one.place.joints(len(names))}
        causes.append(Cause(effect, surest * part, tuple(at), equivalent, presence=surest, alike=at, anywhere=anywhere))
    left_over = 1.0 - sum(cause.probability for cause in causes)
    return causes, max(left_over, 0.0)


def named_of(causes: Sequence[Cause]) -> tuple[str, ...]:
    """Return the effects that are named."""
    return tuple(cause.effect for cause in causes if (cause.presence or 0.0) > NAMED_OVER)


def with_idle(causes: Sequence[Cause], idle: Collection[str]) -> tuple[list[Cause], float]:
    """Return the causes, those that do not stand in the model that would be delivered at half; and what is left.

    With several ways to share a gap, the likeliest shares need not be one of them: some may close nothing there.
    """
    changed = [
        replace(cause, presence=IDLE * (cause.presence or 0.0), probability=IDLE * cause.probability)
        if cause.effect in idle
        else cause
        for cause in causes
    ]
    return changed, max(1.0 - sum(cause.probability for cause in changed), 0.0)


class _Found(NamedTuple):
    """What one step took: how surely it is there, and how surely there or at another joint, and what it closes."""

    place: Placed
    ordinary: bool
    presence: float
    together: float
    share: float
    equivalent: tuple[str, ...]


def _found(step: Step, steps: Sequence[Step], fills: bool, scales: Sequence[Scale]) -> _Found:
    """Return what a step took; what ``fills`` in for another law keeps a part of its presence.

    So does what may be the work of a law outside the library.
    """
    r, best = step.ranking, step.best
    assert best is not None
    place = best.placed[len(step.base.placed)]
    twins = [step.rivals[k - 1].placed[-1].effect for k in alike(step, steps)]
    beside = [model.placed[-1].effect for model in step.as_good]
    shown = r.overall[r.best] if step.worth is None else step.worth.overall[1]
    share = -float(np.log(np.clip(1.0 - shown, 1e-6, 0.99)))  # each has some: the gates saw a gain
    last = {other.key: other for other in last_model(steps).placed}.get(place.key, place)  # beside all others
    ordinary = is_ordinary(last, scales)
    kept = ORDINARY if ordinary else FILLING if fills and not simpler_than(place.effect, (*twins, *beside)) else 1.0
    also = [name for name in last.effect.also(last.values, scales[last.joint]) if name in _tried(step)]
    equivalent = tuple(dict.fromkeys([place.effect.name, *(law.name for law in (*twins, *beside)), *also]))
    decoy = step.look_alike.chance if step.look_alike else 0.0
    kept *= 1.0 - decoy
    sure, together = (presence(evidence(step, worth)) * kept for worth in (step.worth, step.together))
    return _Found(place, ordinary, sure, together, share, equivalent)


def late_as_one(steps: Sequence[Step], joints: int) -> tuple[str, ...]:
    """Return the laws of a delay where all joints are late by the same: which record it is in cannot be told then."""
    placed = [place for place in last_model(steps).placed if place.effect.delays]
    late = [sum(place.values["time"] for place in placed if j in place.joints(joints)) for j in range(joints)]
    if np.ptp(late) >= IN_TIME * np.mean(late):  # nor are joints late that are early
        return ()
    return tuple(effect.name for effect in registry().values() if effect.delays and effect.name in _tried(steps[0]))


def _tried(step: Step) -> set[str]:
    """Return the names of all candidates of a step."""
    return {key[0] for key in step.screened_out} | {model.placed[-1].effect.name for model in step.rivals}


def suspected(step: Step, unknown: float, names: Sequence[str]) -> list[Cause]:
    """Return the causes where the search took nothing, ``unknown`` among them: what came nearest may be there.

    Parameters
    ----------
    step : Step
        The last of the search.
    unknown : float
        Chance of any cause, of which ``unknown`` keeps a part.
    names : sequence of str
        Of the joints.
    """
    places = [step.rivals[k - 1].placed[-1] for k in step.ranking.order]
    first = {place.effect.name: place for place in reversed(places)}
    near = [place for place in places if first[place.effect.name] is place][:MOST_SUSPECTS]
    if not near:
        return [Cause("unknown", unknown)]
    spare = (1.0 - UNKNOWN_HELD) * unknown / len(near)
    found = [(p.effect.name, tuple(names[j] for j in p.joints(len(names)))) for p in near]
    causes = [Cause(name, spare, joints, (name,), presence=spare) for name, joints in found]
    return [*causes, Cause("unknown", UNKNOWN_HELD * unknown)]


def shaken(nothing: Cause, step: Step, joints: Sequence[str], listed: Collection[str]) -> list[Cause]:
    """Return ``none`` and what random torque at some joints may come from, which takes its share of it.

    Parameters
    ----------
    nothing : Cause
        ``none``, with its probability.
    step : Step
        The first one: only effects that it tried are told.
    joints : sequence of str
        Joints at which the torque left is random.
    listed : collection of str
        Effects that are causes already.
    """
    possible = _tried(step) - set(listed)
    names = [effect.name for effect in registry().values() if effect.patternless and effect.name in possible]
    if not joints or not names:
        return [nothing]
    part = FROM_OUTSIDE * nothing.probability / len(names)
    causes = [Cause(name, part, tuple(joints), (name,), presence=part) for name in names]
    return [*causes, replace(nothing, probability=(1.0 - FROM_OUTSIDE) * nothing.probability)]


def with_observed(
    verdict: str, causes: Sequence[Cause], seen: Sequence[Cause], in_torque: int
) -> tuple[str, list[Cause]]:
    """Return verdict and causes with those that the records show by themselves, which take their share.

    Parameters
    ----------
    verdict : str
        From the torque.
    causes : sequence of Cause
        From the torque, ``none`` and ``unknown`` included.
    seen : sequence of Cause
        From the records.
    in_torque : int
        Number of effects that the torque names.
    """
    if not seen:
        return verdict, list(causes)
    others = in_torque if verdict != "unexplained" else 1
    chance = sum(cause.presence or 0.0 for cause in seen) / len(seen)
    share = chance * len(seen) / (len(seen) + others)
    total = sum(cause.presence or 0.0 for cause in seen)
    own = [replace(cause, probability=share * (cause.presence or 0.0) / total) for cause in seen]
    rest = [replace(cause, probability=cause.probability * (1.0 - share)) for cause in causes]
    changed = {"no_gap": "explained", "unexplained": "partly_explained"}.get(verdict, verdict)
    return changed, [*own, *rest]


def no_gap_probability(step: Step, noise: Noise | None, floor: np.ndarray, scales: Sequence[Scale]) -> float:
    """Return the probability that nothing is there, where no effect was taken.

    A gap that fitted runs alone show is one as well. The floor is known to a factor: a little of the torque may be its
    error, a larger part is a gap.
    """
    base = step.base
    everywhere = np.mean(noise_power(noise, floor, len(base.whole), base.rows), axis=0)
    whole = np.sqrt(np.mean(base.whole**2, axis=0))
    ratio = np.maximum(base.rms() / floor, whole / np.sqrt(everywhere))
    part = whole / np.array([max(scale.torque, 1e-12) for scale in scales])
    silent_to = SILENT_OF_MUCH + (SILENT_TO - SILENT_OF_MUCH) / (1.0 + (part / SLIGHT) ** 2)
    # a rival that the search turned down says little against: it closes nothing above the floor
    chance = max(float(step.ranking.probability[0]), 0.5) ** 0.25
    return float(chance * expit(8.0 * np.min(silent_to - ratio)))
