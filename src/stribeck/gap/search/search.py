"""The search: add the best effect while it earns its place on held-out data, then try to drop each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
from joblib import Parallel, delayed

from stribeck.effects.registry import registry
from stribeck.gap.fitted.model import Model, finite, fit_model, referred, weights_of
from stribeck.gap.fitted.white import noise_of_best
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.search.beside import SURELY, idle, outdone, weighed, without_each
from stribeck.gap.search.candidates import Trial, candidates
from stribeck.gap.search.families import best_laws, best_of_each, close_laws, laws_instead, relawed
from stribeck.gap.search.gates import LARGE_GAIN, LEAST_GAIN, earns_its_place
from stribeck.gap.search.look_alike import with_look_alikes
from stribeck.gap.search.ordinary import is_ordinary, ordinary, retuned_with
from stribeck.gap.search.presence import CENTRE, evidence, presence
from stribeck.gap.search.random_torque import random_joints
from stribeck.gap.search.rank import rank
from stribeck.gap.search.screen import screen
from stribeck.gap.search.step import Step, last_model
from stribeck.identify.problem import Weights
from stribeck.identify.residual import Residual
from stribeck.model.layout import Placed
from stribeck.model.path import SignalPath

LEAST_SURVIVORS, LEAST_AT_JOINT = 3, 2
MOST_SURVIVORS = 8
HOPEFUL = 0.3  # of the best promise: candidates with less are not fitted
MOST_EFFECTS = 3
MOST_ROUNDS = 4  # of a search that starts anew from a model with more of what every arm has
HARDLY = 0.15  # presence below which the search ends, unless the effect takes much: what hides it may come next
RELIEVED = 0.85  # of a joint's residual: an effect that leaves less is fitted once more, with weights of its own
AGAIN = 4  # times at most


Progress = Callable[[str], None]
Known: TypeAlias = dict[tuple[str, str, int], dict[str, float]]  # values by law and joint


def search(
    prepared: Prepared,
    base: Model,
    floor: np.ndarray,
    *,
    seed: int = 0,
    jobs: int = 2,
    leave_out: Sequence[str] = (),
    progress: Progress = lambda text: None,
) -> tuple[Prepared, tuple[Step, ...]]:
    """Return the recordings, as the re-tuned model is compared by them, and the steps of the search from there.

    Forward first, from a model that is re-tuned with what every arm has, where that is found. Then each effect is tried
    without: what it is worth beside the others. One that was taken for the sake of a later one (masking) is not needed
    any more, and the search is made again without it.

    Parameters
    ----------
    floor : array (n,)
        What encoder noise and filters leave on the held-out runs, N m rms; noise in the torque is added to it.
    leave_out : sequence of str
        Effects that are no candidates.
    """
    _ = prepared.loud  # once, for all processes
    with Parallel(n_jobs=jobs) as pool:
        setting = _Setting(referred(prepared, base), floor, seed, pool, tuple(leave_out), frozenset(), progress)
        setting, base, found = _from_the_ordinary(setting, base)
        prepared = setting.prepared
        steps, without = _believed(setting, found)
        unneeded = idle(steps)
        needless = unneeded or outdone(prepared, steps, pool, seed, leave_out)
        if needless is not None:
            progress(f"again without {needless[0]}")
            barring, _, other = _from_the_ordinary(replace(setting, barred=frozenset({needless})), base)
            ranking = rank(prepared, [last_model(steps), last_model(other)], steps[-1].floor, seed)
            better = ranking.overall[1] > -LEAST_GAIN if unneeded else ranking.probability[1] > SURELY
            if better:
                prepared = barring.prepared
                steps, without = _believed(barring, other)
        return prepared, with_look_alikes(prepared, steps, without, pool, seed)


@dataclass(frozen=True)
class _Setting:
    """What stays the same during a search."""

    prepared: Prepared
    floor: np.ndarray
    seed: int
    pool: Any
    leave_out: tuple[str, ...]
    barred: frozenset[tuple[str, int]]
    progress: Progress


def _believed(setting: _Setting, steps: tuple[Step, ...]) -> tuple[tuple[Step, ...], list[Model]]:
    """Return the steps with what each effect is worth, without a last one that is hardly there beside the others.

    Beside what does the same work as well, an effect is worth little. With them, the last model without each effect.
    """
    prepared, pool, seed = setting.prepared, setting.pool, setting.seed
    without = without_each(prepared, steps, pool)
    steps = weighed(prepared, steps, without, seed)
    taken = sum(step.taken for step in steps)
    if taken > 1 and _hardly(steps[taken - 1]):
        steps = (*steps[: taken - 1], replace(steps[taken - 1], passing=(), worth=None))
        without = without_each(prepared, steps, pool)
        steps = weighed(prepared, steps, without, seed)
    return steps, without


def _from_the_ordinary(setting: _Setting, base: Model) -> tuple[_Setting, Model, tuple[Step, ...]]:
    """Return the first steps of a search that starts anew, re-tuned with what every arm has, where it finds that."""
    own, scales = len(base.placed), setting.prepared.scales
    known: Known = {}
    steps = _forward(setting, base, known)
    for _ in range(MOST_ROUNDS):
        if not ordinary(steps, scales):
            return setting, base, steps
        setting.progress("again, re-tuned with what every arm has")
        again = retuned_with(setting.prepared, setting.floor, base, own, steps)
        if again is None:
            break
        anew = replace(setting, prepared=referred(setting.prepared, again))
        further = _forward(anew, again, known)
        if not all(is_ordinary(place, scales) for place in last_model(further).placed[own : len(again.placed)]):
            break  # it would grow into a cause beside what is found
        setting, base, steps = anew, again, further
    return setting, base, _forward(setting, base, known, steps) if ordinary(steps, scales) else steps


def _forward(setting: _Setting, base: Model, known: Known, before: Sequence[Step] = ()) -> tuple[Step, ...]:
    """Return steps that take one effect after the other; what every arm has ends them, unless it came ``before``.

    What a law came to in screening is ``known`` to later steps.
    """
    steps = list(before)
    own = len(base.placed)
    base = last_model(before) if before else base
    while len(steps) < MOST_EFFECTS:
        step = _step(setting, base, base.placed[own:], known, steps[-1].floor if steps else None)
        steps.append(step)
        if not step.taken or step.best is None or _hardly(step):
            break
        if not before and ordinary(steps, setting.prepared.scales):
            break
        base = step.best
        if len(steps) > 1:
            base = relawed(setting.prepared, setting.floor, setting.pool, base, own, known)
            steps[-1] = replace(step, rivals=tuple(base if model is step.best else model for model in step.rivals))
    return tuple(steps)


def _hardly(step: Step) -> bool:
    """Return whether what a step took is hardly there, and hides nothing else."""
    seen = replace(evidence(step), left=CENTRE.left)  # what is left may be what it hides
    return bool(presence(seen) < HARDLY and step.ranking.overall[step.ranking.best] < LARGE_GAIN)


def _step(
    setting: _Setting,
    base: Model,
    taken: Sequence[Placed],
    known: Known,
    before: np.ndarray | None,
) -> Step:
    prepared, floor, pool = setting.prepared, setting.floor, setting.pool
    weights = weights_of(base, prepared, floor)
    base = fit_model(prepared, base.placed, weights, base.fit)
    possible = candidates(prepared.arm, base.placed, setting.leave_out)
    possible = [(effect, joint) for effect, joint in possible if (effect.name, joint) not in setting.barred]
    setting.progress(f"screening {len(possible)} candidates")
    # a joint with a slow gap has few independent rows; counted joint by joint, another's noise would outbid it
    even = replace(weights, correlation=np.full_like(weights.correlation, weights.correlation.max()))
    states = _states(prepared, base)
    tried = pool(
        delayed(screen)(prepared, base, even, effect, joint, known.get((effect.name, effect.law, joint)), states)
        for effect, joint in possible
    )
    known.update({trial.law_key: trial.start for trial in tried if np.isfinite(trial.promise)})
    best_trials = _survivors(best_laws(tried), strained=bool(base.fit.at_limit))
    cost = 0.5 * np.sum((base.fit.residual * even.scale) ** 2, axis=0)
    best_trials += close_laws(tried, best_trials, cost)
    setting.progress(f"fitting {len({trial.key for trial in best_trials})} candidates")
    order = list(registry())
    best_trials = sorted(best_trials, key=lambda trial: (order.index(trial.effect.name), trial.joint))
    fitted = pool(delayed(_fit_trial)(prepared, base, weights, trial, floor) for trial in best_trials)
    instead = laws_instead(
        tried, {t.law_key: model for t, model in zip(best_trials, fitted, strict=True)}, cost, prepared
    )
    fitted += pool(delayed(_fit_trial)(prepared, base, weights, trial, floor) for trial in instead)
    rivals = best_of_each(fitted, prepared, floor)
    floor = noise_of_best(floor, [base, *rivals], prepared, before)
    ranking = rank(prepared, [base, *rivals], floor, setting.seed)
    random = tuple(random_joints(prepared, base, floor, setting.seed))
    passing = tuple(
        k for k in ranking.order if earns_its_place(ranking, k, rivals[k - 1], prepared.scales, taken, random)
    )
    if passing:
        ranking = replace(ranking, best=passing[0])
    kept = {(model.placed[-1].effect.name, model.placed[-1].joint) for model in rivals}
    tried_out = dict.fromkeys((effect.name, joint) for effect, joint in possible)
    out = tuple(key for key in tried_out if key not in kept)
    return Step(base, tuple(rivals), ranking, passing, out, floor)


def _states(prepared: Prepared, base: Model) -> tuple[np.ndarray, ...] | None:
    """Return the states (N, nx) of a model along the fitted runs; None where it has none."""
    residual = Residual(SignalPath(prepared.arm, base.placed), prepared.fit, ())
    return tuple(residual.states(run, base.fit.p) for run in prepared.fit) if residual.path.x.numel() else None


def _survivors(tried: Sequence[Trial], *, strained: bool) -> list[Trial]:
    """Return the trials that are worth a full fit: the most hopeful ones, a few at each joint.

    Where re-tuning has come to its limits (``strained``), what the limits forbid is linear no more, and the laws that
    such values mimic are fitted in any case.
    """
    ordered = sorted((trial for trial in tried if np.isfinite(trial.promise)), key=lambda trial: -trial.promise)
    best = ordered[0].promise if ordered else 0.0
    here: dict[int, int] = {}
    kept: list[Trial] = []
    for place, trial in enumerate(ordered):
        here[trial.joint] = here.get(trial.joint, 0) + 1
        first = place < LEAST_SURVIVORS or here[trial.joint] <= LEAST_AT_JOINT
        asked = strained and trial.effect.rescales
        if first or asked or (trial.promise > HOPEFUL * best and len(kept) < MOST_SURVIVORS):
            kept.append(trial)
    return kept


def _fit_trial(prepared: Prepared, base: Model, weights: Weights, trial: Trial, floor: np.ndarray) -> Model | None:
    placed = (*base.placed, Placed(trial.effect, trial.joint))
    far = trial.effect.rescales and bool(base.fit.at_limit)
    model = fit_model(prepared, placed, weights, base.fit, trial.start, evaluations=60 if far else 20)
    if not finite(model):
        return None
    # a gap that is gone had made the whole joint count for little: what is left deserves its own weights, in turn
    for _ in range(AGAIN):
        own = weights_of(model, prepared, floor)
        if np.all(np.mean(own.sd**2, axis=0) > RELIEVED**2 * np.mean(weights.sd**2, axis=0)):
            break
        again = fit_model(prepared, model.placed, own, model.fit, evaluations=15)
        if not finite(again):
            break
        model, weights = again, own
    return model
