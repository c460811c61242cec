"""Which law of a family stands for an effect: before a full fit, after it, and once other effects are there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from joblib import delayed

from stribeck.effects.registry import laws
from stribeck.gap.fitted.model import Model, finite, fit_model, weights_of
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.search.candidates import Trial
from stribeck.gap.search.gates import LEAST_GAIN, holds
from stribeck.model.layout import Placed, rival

MOST = 0.5  # of the base's cost at a joint, that a law takes for others of its family to be fitted beside it
CLOSE, HALF = 0.9, 0.5  # of what it takes, that these take; and where it rests on a bound
SPARING = 0.01  # of the logarithm of the squares left, that one more parameter of a law must take
RELAWED = 40  # evaluations of a model with another law for one of its effects


def best_laws(tried: Sequence[Trial]) -> list[Trial]:
    """Return the trials with, of each family at each joint, the law that promises most; ties go to the first."""
    best: dict[tuple[str, int], Trial] = {}
    for trial in tried:
        if trial.key not in best or trial.promise > best[trial.key].promise:
            best[trial.key] = trial
    return list(best.values())


def close_laws(tried: Sequence[Trial], kept: Sequence[Trial], cost: np.ndarray) -> list[Trial]:
    """Return other laws of the kept trials' families that take about as much of a gap which they take most of.

    Against the whole of a gap the laws of one family hardly differ; what they leave of it does, once they are fitted.

    Parameters
    ----------
    tried, kept : sequence of Trial
        All, and those that are fitted.
    cost : array (n,)
        Of the base at each joint, by the weights of the trials.
    """
    chosen = {trial.key: trial for trial in kept if trial.promise > MOST * cost[trial.joint]}
    rivals = (trial for trial in tried if trial.key in chosen and trial.effect.law != chosen[trial.key].effect.law)
    return [trial for trial in rivals if trial.promise > CLOSE * chosen[trial.key].promise]


def laws_instead(
    tried: Sequence[Trial],
    fitted: Mapping[tuple[str, str, int], Model | None],
    cost: np.ndarray,
    base: Model,
    prepared: Prepared,
    floor: np.ndarray,
) -> list[Trial]:
    """Return the trials of further laws where a family's law takes most of a gap, and none that was fitted holds.

    At a bound, say, or lost: it leaves hardly less than the base. Most of it by its promise or by its fit, for beside a
    constant at its limit any law promises little. What promises less than half as much would not stand for it.

    Parameters
    ----------
    tried : sequence of Trial
    fitted : mapping
        Models by the law key of their trial.
    cost : array (n,)
        As in :func:`close_laws`.
    base : Model
        Beside which they are tried.
    prepared : Prepared
    floor : array (n,)
        Noise floor, N m rms.
    """
    left = {key: left_by(model.whole, floor) for key, model in fitted.items() if model is not None}
    without = left_by(base.whole, floor)
    sound: dict[tuple[str, int], bool] = {}
    for (name, law, joint), model in fitted.items():
        less = model is not None and left[name, law, joint] < without - LEAST_GAIN
        holds = model is not None and less and _sound(model, len(model.placed) - 1, prepared)
        sound[name, joint] = sound.get((name, joint), False) or holds
    promised: dict[tuple[str, int], float] = {}
    for trial in tried:
        taken = 1.0 - np.exp(left[trial.law_key] - without) if trial.law_key in left else 0.0
        if trial.law_key in fitted and (trial.promise > MOST * cost[trial.joint] or taken > MOST):
            promised[trial.key] = max(promised.get(trial.key, 0.0), trial.promise)
    others = (trial for trial in tried if trial.law_key not in fitted and trial.key in promised)
    return [trial for trial in others if not sound[trial.key] and trial.promise > HALF * promised[trial.key]]


def best_of_each(models: Sequence[Model | None], prepared: Prepared, floor: np.ndarray) -> list[Model]:
    """Return of each candidate the sound law that leaves least on all runs, its placed effect with the fitted values.

    Costs would not do: each model may have weights of its own. Nor fitted runs alone: one that bends to them may leave
    more of the others than no law does.
    """
    best: dict[tuple[str, int], tuple[bool, float, Model]] = {}
    for model in models:
        if model is None:
            continue
        last = len(model.placed) - 1
        key = model.placed[last].key
        dear = SPARING * len(model.placed[last].effect.parameters)
        found = (not _sound(model, last, prepared), left_by(model.whole, floor) + dear, model)
        if key not in best or found[:2] < best[key][:2]:
            best[key] = found
    return [model for _, _, model in best.values()]


def relawed(
    prepared: Prepared,
    floor: np.ndarray,
    pool: Any,
    model: Model,
    own: int,
    known: Mapping[tuple[str, str, int], dict[str, float]],
) -> Model:
    """Return the model with other laws for effects that were taken before the last, where these now leave less.

    What one effect's law could not follow may have been another's.

    Parameters
    ----------
    prepared : Prepared
    floor : array (n,)
        Noise floor, N m rms.
    pool : joblib.Parallel
    model : Model
    own : int
        Number of effects that are the nominal model's own.
    known : mapping
        Starting values by name, law and joint: laws without any are not tried.
    """
    others = []
    for i, place in enumerate(model.placed[own:-1], own):
        before, after = model.placed[:i], model.placed[i + 1 :]
        for effect in laws().values():
            start = known.get((effect.name, effect.law, place.joint))
            other = effect.name == place.effect.name and effect.law != place.effect.law
            if other and start is not None and not rival(effect, place.joint, (*before, *after)):
                others.append((*before, Placed(effect, place.joint, start), *after))
    if not others:
        return model
    weights = weights_of(model, prepared, floor)
    fits = (delayed(fit_model)(prepared, placed, weights, None, evaluations=RELAWED) for placed in others)
    fitted = [other for other in pool(fits) if finite(other) and _sound(other, own, prepared)]
    best = min(fitted, key=lambda other: left_by(other.fit.residual, floor), default=model)
    pairs = ((best.fit.residual, model.fit.residual), (best.held, model.held))
    less = [left_by(before, floor) - left_by(now, floor) for now, before in pairs]
    return best if less[0] > LEAST_GAIN and less[1] > 0.0 else model


def _sound(model: Model, own: int, prepared: Prepared) -> bool:
    """Return whether the effects from the given number on are plausible, and none rests on a bound."""
    scales = [prepared.scales[place.joint] for place in model.placed[own:]]
    return all(holds(place, scale) for place, scale in zip(model.placed[own:], scales, strict=True))


def left_by(residual: np.ndarray, floor: np.ndarray) -> float:
    """Return the logarithm of the mean squared residual (M, n), all joints multiplied."""
    return float(np.sum(np.log(np.mean(residual**2, axis=0) + 0.5 * floor**2)))
