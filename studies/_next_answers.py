"""One case from the first recordings to the answers after each kind of next recording."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from _next_cases import Poor
from _next_lab import followed
from _next_rivals import at_random, d_optimal

from stribeck.errors import StribeckError
from stribeck.gap import diagnose
from stribeck.gap.answer.assembly import Assembly
from stribeck.gap.diagnose import searched
from stribeck.gap.experiment.changes import Change
from stribeck.gap.experiment.plan import Plan
from stribeck.gap.experiment.proposal import Experiment, next_experiment, open_question
from stribeck.gap.experiment.separation import AS_IT_IS, Candidate
from stribeck.gap.records.observed import observe
from stribeck.gap.records.prepare import prepare
from stribeck.gap.result import Cause, Diagnosis
from stribeck.gap.search.setting import Asked
from stribeck.identify.conditioning import condition
from stribeck.run import Run

# No motion tells these apart: with one joint; at the first joint; at any
ALWAYS_SAME = ({"torque_offset", "asymmetric_friction"},)
SAME_AT_FIRST = ({"encoder_offset", "gravity_tilt"},)
SAME_ALONE = ({"delay", "time_shift"},)
METHODS = ("proposed", "random", "d_optimal")
DECIDED = 6.0  # t value between candidates along a recording with a change


def answered(case: Poor) -> dict[str, Any]:
    """Return what is said of a case before and, where that leaves a question open, after the next recording."""
    began = time.process_time()
    prepared = prepare(case.nominal, case.runs)
    found = searched(prepared, Asked(jobs=1))
    prepared, floor = found.prepared, found.steps[-1].floor
    seen = observe(case.nominal, case.runs, prepared.scales)
    first = Assembly(prepared, seen, found.given, found.noise, floor, found.steps, 0).diagnosis()
    row: dict[str, Any] = {**case.words(), "joints": case.nominal.n, "before": said(case, first)}
    row["seconds"] = {"diagnosis": time.process_time() - began}
    if first.next_experiment is None:
        return {**row, "open": False}
    exact = row["before"]["right"]  # and a class: no motion will tell more
    began = time.process_time()
    unexplained = first.verdict == "unexplained"
    models = open_question(found.steps, None if unexplained else first.named)
    experiment = next_experiment(prepared, models, floor, as_it_is=unexplained)
    row["seconds"]["design"] = time.process_time() - began
    if experiment is None:
        return {**row, "open": True, "exact": exact, "experiment": None}
    plan = Plan(prepared, models, floor)
    row |= {"open": True, "exact": exact, "experiment": _in_words(experiment), "after": {}}
    references = _references(plan, experiment, case.seed)
    for method, reference in references.items() if not exact else [("proposed", references["proposed"])]:
        row["after"][method] = _after(case, plan, experiment, method, reference)
    return row


def _references(plan: Plan, experiment: Experiment, seed: int) -> dict[str, Run]:
    duration = experiment.reference.duration
    options = plan.options(experiment.wider)
    return {
        "proposed": experiment.reference,
        "random": at_random(plan, options, duration, seed),
        "d_optimal": d_optimal(plan, options, duration),
    }


def _after(case: Poor, plan: Plan, experiment: Experiment, method: str, reference: Run) -> dict[str, Any]:
    change = experiment.change if method == "proposed" else AS_IT_IS
    try:
        run = followed(case, reference, change)
    except StribeckError as error:
        return {"right": False, "error": str(error)}
    assert reference.q_ref is not None
    off = float(np.max(np.std(run.q - reference.q_ref, axis=0) / (np.std(reference.q_ref, axis=0) + 1e-3)))
    if experiment.change is not AS_IT_IS:  # then for the rivals too, though nothing is changed for theirs
        return {**_by_refitting(case, plan, experiment, run, change), "off": off}
    began = time.process_time()
    answer = said(case, diagnose(case.nominal, [*case.runs, run], jobs=1))
    return {**answer, "off": off, "seconds": time.process_time() - began}


def _by_refitting(case: Poor, plan: Plan, experiment: Experiment, run: Run, change: Change) -> dict[str, Any]:
    """Judge by what each candidate, re-tuned, leaves of a recording with a known change, or with none."""
    arm = plan.prepared.arm
    recorded = condition(arm, run, plan.prepared.cutoff, thin=True)
    noise = plan.noise_along(recorded)
    left = [Candidate(arm, model, plan.weights, change).excess(recorded, noise) for model in plan.models]
    order = np.argsort(left)
    apart = float(np.sqrt(max(left[order[1]] ** 2 - left[order[0]] ** 2, 0.0)))
    best = plan.models[int(order[0])].placed[-1].effect.name
    decided = apart > DECIDED
    return {"right": decided and best == case.hidden.effect, "named": [[best]] if decided else [], "apart": apart}


def said(case: Poor, diagnosis: Diagnosis) -> dict[str, Any]:
    """Return verdict and names, and whether they are right: the true effect, and none beside that could be told."""
    causes = {cause.effect: cause for cause in diagnosis.causes}
    named = [_class(causes[name]) for name in diagnosis.named]
    return {
        "verdict": diagnosis.verdict,
        "named": [sorted(one) for one in named],
        "right": right(case, named),
        "wrong": any(case.hidden.effect not in one for one in named),
        "listed": case.hidden.effect in {name for cause in diagnosis.causes for name in _class(cause)},
        "chance": max((c.presence or 0.0 for c in diagnosis.causes if case.hidden.effect in _class(c)), default=0.0),
    }


def _class(cause: Cause) -> set[str]:
    return {cause.effect, *cause.equivalent}


def right(case: Poor, named: Sequence[set[str]]) -> bool:
    """Whether all that is named is the hidden effect, with none beside it but what no motion tells from it."""
    return len(named) > 0 and all(case.hidden.effect in one and one <= _same(case) for one in named)


def _same(case: Poor) -> set[str]:
    """Return the hidden effect and those that no motion of this arm tells from it."""
    groups = list(ALWAYS_SAME)
    if case.hidden.joint == case.nominal.names[0]:
        groups += SAME_AT_FIRST
    if case.nominal.n == 1:
        groups += SAME_ALONE
    return {case.hidden.effect}.union(*(group for group in groups if case.hidden.effect in group))


def _in_words(experiment: Experiment) -> Mapping[str, Any]:
    return {**experiment.plain(), "wider": experiment.wider, "duration": experiment.reference.duration}
