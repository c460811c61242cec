"""The forward search: add the best effect while it earns its place on held-out data."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from stribeck.gap.fitted.model import Model
from stribeck.gap.search.candidates import Trial
from stribeck.gap.search.families import best_laws, close_laws, laws_instead, left_by, relawed
from stribeck.gap.search.gates import LARGE_GAIN
from stribeck.gap.search.judged import MUCH, Judged, as_hopeful, further_laws, judge
from stribeck.gap.search.ordinary import ordinary
from stribeck.gap.search.presence import CENTRE, evidence, presence
from stribeck.gap.search.setting import Known, Setting
from stribeck.gap.search.step import Step, last_model
from stribeck.gap.search.tryout import Tryout
from stribeck.model.effect import StandEffect, TransmissionEffect
from stribeck.model.layout import Placed

LEAST_SURVIVORS, LEAST_AT_JOINT = 3, 2
MOST_SURVIVORS = 8
MOST_ASKED = 24  # further ones beside strained values
MOST_AGAIN = 4  # rivals of an earlier search that are fitted once more
YIELDING = (TransmissionEffect, StandEffect)  # compliances, of a joint and under the arm
HOPEFUL = 0.3  # of the best promise: candidates with less are not fitted
MOST_EFFECTS, MOST_STEPS = 6, 9  # one effect at two joints takes two steps
FAR_LESS = 1.4  # of the logarithm of the squares left, joints added: a quarter
HARDLY = 0.15  # presence below which the search ends, unless the effect takes much: what hides it may come next


def forward(
    setting: Setting,
    base: Model,
    known: Known,
    before: Sequence[Step] = (),
    same: Sequence[Step] = (),
    until: Callable[[Model], bool] = lambda model: False,
) -> tuple[Step, ...]:
    """Return steps that take one effect after the other; what every arm has ends them, unless it came ``before``.

    What a law came to in screening is ``known`` to later steps. The first ones have the best rivals of the ``same``
    steps of an earlier search, from where these ended, while they come to the same: a base that differs by little
    leaves the same large effects to find.

    Parameters
    ----------
    setting : Setting
    base : Model
        The re-tuned model, from which the search starts.
    known : dict
        Values by name, law and joint, to which screening adds.
    before : sequence of Step
        Steps to go on from.
    same : sequence of Step
        Those of an earlier search from a base that differs by little.
    until : callable
        Told each model that a step has taken: whether the search ends there, to be made in another way.
    """
    steps = list(before)
    own = len(base.placed)
    base = last_model(before) if before else base
    while len(steps) < MOST_STEPS and len({key[0] for step in steps if (key := _key(step))}) < MOST_EFFECTS:
        again = same[len(steps)] if len(steps) < len(same) else None
        tryout = Tryout(setting, base, known)
        given = setting, tryout, base.placed[own:], steps[-1].floor if steps else None
        step = _step(*given, again)
        if again is not None and _key(step) != _key(again):
            same = ()
            step = _step(*given)
        steps.append(step)
        if not step.taken or step.best is None or hardly(step):
            break
        if not before and ordinary(steps, setting.prepared.scales):
            break
        base = step.best
        if len(steps) > 1:
            base = relawed(setting.prepared, setting.floor, setting.pool, base, own, known)
            steps[-1] = replace(step, rivals=tuple(base if model is step.best else model for model in step.rivals))
        if until(base):
            break
    return tuple(steps)


def _key(step: Step) -> tuple[str, int] | None:
    """Return the effect and joint that a step took, or None."""
    return step.best.placed[-1].key if step.taken and step.best is not None else None


def hardly(step: Step) -> bool:
    """Return whether what a step took is hardly there, and hides nothing else."""
    seen = replace(evidence(step), left=CENTRE.left)  # what is left may be what it hides
    return bool(presence(seen) < HARDLY and step.ranking.overall[step.ranking.best] < LARGE_GAIN)


def _step(
    setting: Setting, tryout: Tryout, taken: Sequence[Placed], before: np.ndarray | None, same: Step | None = None
) -> Step:
    prepared, base = setting.prepared, tryout.base
    again = [] if same is None else _as_before(same, tryout)
    if again:
        other = _other_laws(again[0], tryout)
        tried = tryout.screened(other) if other else []
        best_trials = again + best_laws(tried)
    else:
        tried = tryout.screened()
        best_trials = _survivors(best_laws(tried), strained=bool(base.fit.at_limit))
    best_trials += close_laws(tried, best_trials, tryout.cost)
    setting.progress(f"fitting {len({trial.key for trial in best_trials})} candidates")
    fitted = tryout.fitted(best_trials)
    known = {trial.law_key: model for trial, model in zip(best_trials, fitted, strict=True)}
    instead = laws_instead(tried, known, tryout.cost, base, prepared, setting.floor)
    fitted += tryout.fitted(instead)
    judged = judge(prepared, setting.floor, setting.seed, base, fitted, taken, before)
    further = further_laws(tried, {trial.law_key for trial in (*best_trials, *instead)}, judged)
    further += as_hopeful(best_laws(tried), {trial.key for trial in best_trials}, judged)
    if further:
        fitted += tryout.fitted(further)
        judged = judge(prepared, setting.floor, setting.seed, base, fitted, taken, before)
    found = [] if again else _sought(tryout, judged)
    if found:
        judged = judge(prepared, setting.floor, setting.seed, base, [*fitted, *found], taken, before)
    rivals, ranking, passing, floor = judged
    kept = {model.placed[-1].key for model in rivals}
    tried_out = dict.fromkeys((effect.name, joint) for effect, joint in tryout.possible)
    out = tuple(key for key in tried_out if key not in kept)
    return Step(base, tuple(rivals), ranking, passing, out, floor)


def _as_before(same: Step, tryout: Tryout) -> list[Trial]:
    """Return trials of what an earlier search's step took and of its next best rivals, from where these ended.

    Not of what the base has by now, as what every arm has, or what does not go with that.
    """
    order = dict.fromkeys((same.ranking.best, *same.ranking.order))
    ends = [same.rivals[k - 1].placed[-1] for k in order]
    trials = [Trial(place.effect, place.joint, dict(place.values), fitted=True) for place in ends]
    possible = {(effect.name, joint) for effect, joint in tryout.possible}
    return [trial for trial in trials if trial.key in possible][:MOST_AGAIN]


def _other_laws(trial: Trial, tryout: Tryout) -> set[tuple[str, str, int]]:
    """Return the other laws of a trial's family at its joint."""
    same = {(effect.name, effect.law, joint) for effect, joint in tryout.possible if (effect.name, joint) == trial.key}
    return same - {trial.law_key}


def _sought(tryout: Tryout, judged: Judged) -> list[Model]:
    """Return compliances that leave far less than what a step would take, where that leaves far more than noise.

    With an observer any of them follows random torque a little; one that is there does the most of it.
    """
    best, floor = judged.ranking.best if judged.passing else 0, judged.floor
    much = [joint for joint, power in enumerate(judged.ranking.power[best]) if power > MUCH**2]
    if not much:
        return []
    model = judged.rivals[best - 1] if best else tryout.base
    least = left_by(model.whole, floor) - FAR_LESS
    return [found for found in tryout.sought(much) if left_by(found.whole, floor) < least]


def _survivors(tried: Sequence[Trial], *, strained: bool) -> list[Trial]:
    """Return the trials that are worth a full fit: the most hopeful ones, compliances and all others by themselves.

    Screened without an observer, a compliance takes noise from a residual besides: at each joint of a long arm two of
    them may promise more than what is there, and their fits take long. Where re-tuning has come to its limits
    (``strained``), what these forbid is linear no more, and what a law promises there says little: of those that do not
    take long the best ones are fitted in any case, and what rescales, which such values mimic.
    """
    firm = [trial for trial in tried if not isinstance(trial.effect, YIELDING)]
    hopeful = _most_hopeful(firm)
    kept = {trial.key for trial in hopeful}
    others = [t for t in firm if t.key not in kept and not t.effect.nonlinear and np.isfinite(t.promise)]
    others.sort(key=lambda t: (not t.effect.rescales, -t.promise))
    asked = others[:MOST_ASKED]
    yielding = [trial for trial in _most_hopeful(tried) if isinstance(trial.effect, YIELDING)]
    return hopeful + (asked if strained else []) + yielding[:MOST_SURVIVORS]


def _most_hopeful(tried: Sequence[Trial]) -> list[Trial]:
    """Return the trials that promise most, a few at each joint."""
    ordered = sorted((trial for trial in tried if np.isfinite(trial.promise)), key=lambda trial: -trial.promise)
    best = ordered[0].promise if ordered else 0.0
    here: dict[int, int] = {}
    kept: list[Trial] = []
    for place, trial in enumerate(ordered):
        here[trial.joint] = here.get(trial.joint, 0) + 1
        first = place < LEAST_SURVIVORS or here[trial.joint] <= LEAST_AT_JOINT
        if first or (trial.promise > HOPEFUL * best and len(kept) < MOST_SURVIVORS):
            kept.append(trial)
    return kept
