"""The forward search: add the best effect while it earns its place on held-out data."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeAlias

import numpy as np
from joblib import delayed

from stribeck.gap.fitted.model import Model, finite, fit_model, weights_of
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.search.candidates import Trial, candidates
from stribeck.gap.search.families import best_laws, close_laws, laws_instead, relawed
from stribeck.gap.search.gates import LARGE_GAIN
from stribeck.gap.search.judged import as_hopeful, judge
from stribeck.gap.search.ordinary import ordinary
from stribeck.gap.search.presence import CENTRE, evidence, presence
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
HARDLY = 0.15  # presence below which the search ends, unless the effect takes much: what hides it may come next
RELIEVED = 0.85  # of a joint's residual: an effect that leaves less is fitted once more, with weights of its own
AGAIN = 4  # times at most


Progress = Callable[[str], None]
Known: TypeAlias = dict[tuple[str, str, int], dict[str, float]]  # values by law and joint


@dataclass(frozen=True)
class Setting:
    """What stays the same during a forward search; the first, ``stated`` effects of its base are the arm file's.

    One that is made ``anew`` starts from a model that differs by little from the one before.
    """

    prepared: Prepared
    floor: np.ndarray
    seed: int
    pool: Any
    leave_out: tuple[str, ...]
    barred: frozenset[tuple[str, int]]
    progress: Progress
    stated: int = 0
    anew: bool = False


def forward(
    setting: Setting, base: Model, known: Known, before: Sequence[Step] = (), same: Sequence[Step] = ()
) -> tuple[Step, ...]:
    """Return steps that take one effect after the other; what every arm has ends them, unless it came ``before``.

    What a law came to in screening is ``known`` to later steps. The first ones have the rivals of the ``same`` steps of
    an earlier search, while they come to the same: a base that differs by little leaves the same large effects to find.
    """
    steps = list(before)
    own = len(base.placed)
    base = last_model(before) if before else base
    while len(steps) < MOST_EFFECTS:
        again = same[len(steps)] if len(steps) < len(same) else None
        given = base.placed[own:], known, steps[-1].floor if steps else None, Done()
        step = _step(setting, base, *given, again)
        if again is not None and _key(step) != _key(again):
            same = ()
            step = _step(setting, base, *given)
        steps.append(step)
        if not step.taken or step.best is None or hardly(step):
            break
        if not before and ordinary(steps, setting.prepared.scales):
            break
        base = step.best
        if len(steps) > 1:
            base = relawed(setting.prepared, setting.floor, setting.pool, base, own, known)
            steps[-1] = replace(step, rivals=tuple(base if model is step.best else model for model in step.rivals))
    return tuple(steps)


@dataclass
class Done:
    """What was tried from one base: trials by law and joint, and the models that were fitted from them."""

    trials: dict[tuple[str, str, int], Trial] = field(default_factory=dict)
    models: dict[tuple[str, str, int], Model | None] = field(default_factory=dict)


def _key(step: Step) -> tuple[str, int] | None:
    """Return the effect and joint that a step took, or None."""
    return step.best.placed[-1].key if step.taken and step.best is not None else None


def hardly(step: Step) -> bool:
    """Return whether what a step took is hardly there, and hides nothing else."""
    seen = replace(evidence(step), left=CENTRE.left)  # what is left may be what it hides
    return bool(presence(seen) < HARDLY and step.ranking.overall[step.ranking.best] < LARGE_GAIN)


def _step(
    setting: Setting,
    base: Model,
    taken: Sequence[Placed],
    known: Known,
    before: np.ndarray | None,
    done: Done,
    same: Step | None = None,
) -> Step:
    prepared, floor, pool = setting.prepared, setting.floor, setting.pool
    weights = weights_of(base, prepared, floor)
    base = fit_model(prepared, base.placed, weights, base.fit)
    possible = candidates(prepared.arm, base.placed, setting.leave_out)
    possible = [(effect, joint) for effect, joint in possible if (effect.name, joint) not in setting.barred]
    then = None if same is None else {model.placed[-1].key for model in same.rivals}
    among = [(effect, joint) for effect, joint in possible if then is None or (effect.name, joint) in then]
    new = [(effect, joint) for effect, joint in among if (effect.name, effect.law, joint) not in done.trials]
    setting.progress(f"screening {len(new)} candidates")
    # a joint with a slow gap has few independent rows; counted joint by joint, another's noise would outbid it
    even = replace(weights, correlation=np.full_like(weights.correlation, weights.correlation.max()))
    states = _states(prepared, base)
    screened = pool(
        delayed(screen)(
            prepared, base, even, effect, joint, known.get((effect.name, effect.law, joint)), states, setting.anew
        )
        for effect, joint in new
    )
    known.update({trial.law_key: trial.start for trial in screened if np.isfinite(trial.promise)})
    done.trials.update({(e.name, e.law, joint): trial for (e, joint), trial in zip(new, screened, strict=True)})
    tried = [done.trials[effect.name, effect.law, joint] for effect, joint in among]

    def fit_all(trials: Sequence[Trial]) -> list[Model | None]:
        anew = [trial for trial in trials if trial.law_key not in done.models]
        models = pool(delayed(_fit_trial)(prepared, base, weights, trial, floor) for trial in anew)
        done.models.update(zip((trial.law_key for trial in anew), models, strict=True))
        return [done.models[trial.law_key] for trial in trials]

    best_trials = _survivors(best_laws(tried), strained=bool(base.fit.at_limit))
    cost = 0.5 * np.sum((base.fit.residual * even.scale) ** 2, axis=0)
    best_trials += close_laws(tried, best_trials, cost)
    setting.progress(f"fitting {len({trial.key for trial in best_trials})} candidates")
    fitted = fit_all(best_trials)
    instead = laws_instead(
        tried, {t.law_key: model for t, model in zip(best_trials, fitted, strict=True)}, cost, prepared
    )
    fitted += fit_all(instead)
    judged = judge(prepared, floor, setting.seed, base, fitted, taken, before)
    same_hopes = as_hopeful(best_laws(tried), {trial.key for trial in best_trials}, judged)
    if same_hopes:
        fitted += fit_all(same_hopes)
        judged = judge(prepared, floor, setting.seed, base, fitted, taken, before)
    rivals, ranking, passing, floor = judged
    kept = {model.placed[-1].key for model in rivals}
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
