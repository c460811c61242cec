"""What to do with the answer: one sentence or two for each verdict."""

from __future__ import annotations

import math
from collections.abc import Mapping

from stribeck.gap.answer.verdict import AT_FLOOR
from stribeck.gap.result import Diagnosis
from stribeck.model.scale import PROMPT
from stribeck.report import words
from stribeck.report.numbers import probability

UNLIKELY = 0.2  # probability below which an experiment is not said to tell anything


def what_next(diagnosis: Diagnosis) -> str:
    """Return what an engineer does next: which model to use, where to look, what to record."""
    use = _use(diagnosis)
    if diagnosis.verdict == "no_gap":
        return f"Use corrected.toml, the arm file with its values re-tuned: {use}."
    if not diagnosis.named:
        experiment = _experiment(
            diagnosis, "the recording below, diagnosed together with these, may bring the cause out"
        )
        look = "" if experiment else f" {_look(diagnosis)}"
        return f"corrected.toml is the arm file with its values re-tuned; no cause is added.{experiment}{look}"
    experiment = _experiment(diagnosis, "the experiment below is meant to tell apart what these data cannot")
    if diagnosis.verdict == "explained":
        return f"Use corrected.toml, in which the model has what is named: {use}.{experiment}"
    return f"corrected.toml has what is named, and is as wrong as the figures show. {_look(diagnosis)}{experiment}"


def _use(diagnosis: Diagnosis) -> str:
    """Return which commands take the corrected arm."""
    arm = diagnosis.models.get("corrected")
    early = arm is not None and any(
        values.get("time", 0.0) <= -PROMPT for entry in arm.effects for values in entry.parameters.values()
    )
    if early:
        return "predict takes it; no loop and no FMU can have a record that is early"
    return "predict, simulate, limit-cycle and export-fmu take it"


def _experiment(diagnosis: Diagnosis, does: str) -> str:
    """Return what the next experiment is for, where there is one; a sentence, or nothing."""
    told = diagnosis.next_experiment
    if not told:
        return ""
    gain = told.get("expected_gain")
    chance = gain.get("probability_resolved", math.nan) if isinstance(gain, Mapping) else math.nan
    doubt = f", though it is unlikely to (probability {probability(chance)})" if chance < UNLIKELY else ""
    return f" {does[0].upper()}{does[1:]}{doubt}."


def _look(diagnosis: Diagnosis) -> str:
    """Return where what is left lies, and what would show more of it."""
    stages = {stage.stage: stage.torque for stage in diagnosis.stages}
    last, floor = (stages.get(name, {}) for name in (words.last_stage(diagnosis), "noise_floor"))
    left = [joint for joint in diagnosis.joints if last.get(joint, 0.0) > AT_FLOOR * floor.get(joint, math.inf)]
    at = words.joints(left) if left else "the arm"
    return f"What is left is at {at}: look there first, and record motions that bring more of it out."
