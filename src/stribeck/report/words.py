"""Names as words: effects, stages, verdicts, joints and regions as a sentence or a label needs them."""

from __future__ import annotations

import re

from stribeck.arm import unit_at
from stribeck.gap.result import Cause, Diagnosis
from stribeck.report.numbers import MINUS

VERDICT = {
    "no_gap": "No gap",
    "explained": "Explained",
    "partly_explained": "Partly explained",
    "unexplained": "Unexplained",
}
_STAGE = {"as_given": "as given", "retuned": "re-tuned", "noise_floor": "noise floor"}
_PREPOSITION = (
    ("reversal", "at velocity reversals"),
    ("stuck", "while the joint sticks"),
    ("forward", "in forward motion"),
    ("backward", "in backward motion"),
    ("all motion", "throughout the motion"),
)


def clean(text: object) -> str:
    """Return text on one line without control characters: names come from files that anyone may have written."""
    return " ".join("".join(c if c.isprintable() else " " for c in str(text)).split())


def short(text: object, limit: int = 24) -> str:
    """Return a clean name of at most ``limit`` characters, its middle left out."""
    name = clean(text)
    if len(name) <= limit:
        return name
    tail = (limit - 1) // 2
    return f"{name[: limit - 1 - tail]}…{name[-tail:]}"


def effect(name: str) -> str:
    """Return ``position_dependent_friction`` as "position-dependent friction"."""
    return clean(name).replace("_dependent", "-dependent").replace("_", " ")


def stage(name: str) -> str:
    """Return a stage as a label: "as given", "re-tuned", "+ presliding", "noise floor"."""
    return _STAGE.get(name, f"+ {effect(name)}")


def span(name: str) -> str:
    """Return the name of a region with minus signs for hyphens before its numbers: "−0.38 to 0.22 rad"."""
    return re.sub(r"(?<!\S)-(?=\d)", MINUS, clean(name))


def region(name: str) -> str:
    """Return where in the motion a region is, as the end of a sentence: "at velocity reversals"."""
    words = span(name).replace("_", " ")
    for key, phrase in _PREPOSITION:
        if re.search(rf"\b{key}s?\b", words):
            return phrase
    if re.search(r" to .* Hz$", words):
        return f"between {words.replace(' to ', ' and ')}"
    if re.search(r" to .* (rad|m)$", words):
        return f"at positions of {words}"
    if words.startswith("at "):
        return words
    if words.endswith("of a run"):
        return f"in the {words}"
    if re.match(r"(very )?(low|medium|high)(er)? (speed|velocity|acceleration|load|torque)", words):
        return f"at {words}"
    return f"in “{words}”"


def listing(items: tuple[str, ...] | list[str], last: str = "and") -> str:
    """Return "A, B and C"."""
    items = list(items)
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} {last} {items[-1]}" if items else ""


def joints(names: tuple[str, ...] | list[str], last: str = "and") -> str:
    """Return "joint A" or "joints A and B"."""
    if not names:
        return "the arm"
    text = listing([clean(name) for name in names], last)
    if any("joint" in name.lower() for name in names):  # "joint_3" says it already
        return text
    return f"{'joint' if len(names) == 1 else 'joints'} {text}"


def cause_of(diagnosis: Diagnosis, name: str) -> Cause:
    """Return the likeliest cause of that effect; one without a probability where the list lacks it."""
    found = [cause for cause in diagnosis.causes if cause.effect == name]
    return max(found, key=lambda cause: cause.probability, default=Cause(name, float("nan"), (), (name,)))


def class_probability(diagnosis: Diagnosis, cause: Cause) -> float:
    """Return the probability that a cause, or one that the data cannot tell from it, is there."""
    if cause.presence is not None:
        return cause.presence
    others = {
        other.effect: other.probability for other in reversed(diagnosis.causes) if other.effect in cause.equivalent
    }
    return min(sum({**others, cause.effect: cause.probability}.values()), 1.0)


def probability_of(diagnosis: Diagnosis, name: str) -> float:
    """Return the probability of ``none`` or ``unknown``; 0 where the list lacks it."""
    return sum(cause.probability for cause in diagnosis.causes if cause.effect == name)


def named(diagnosis: Diagnosis) -> str:
    """Return the named effects as the start of a sentence: "Presliding and cable spring"."""
    text = listing([effect(name) for name in diagnosis.named])
    return f"{text[:1].upper()}{text[1:]}"


def chosen(diagnosis: Diagnosis, name: str) -> str:
    """Return what became of an effect that a step of the search chose: "added", or "tried, not named"."""
    return "added" if name in diagnosis.named else "tried, not named"


def last_stage(diagnosis: Diagnosis) -> str:
    """Return the stage of the final model: the last effect that was added, or "retuned"."""
    added = [stage.stage for stage in diagnosis.stages if stage.stage not in _STAGE]
    return added[-1] if added else "retuned"


def in_records_alone(diagnosis: Diagnosis) -> bool:
    """Return whether what is named shows in the records alone: re-tuning leaves no gap of torque."""
    return diagnosis.closed is None and last_stage(diagnosis) == "retuned" and not diagnosis.where


def final(diagnosis: Diagnosis) -> str:
    """Return what the last model is called: "corrected", or "re-tuned" where no effect was added to it."""
    return "corrected" if diagnosis.named else "re-tuned"


def of_one(diagnosis: Diagnosis) -> bool:
    """Return whether a part of a recording judges what is fitted to the rest of the same one."""
    return not set(diagnosis.fit_runs).isdisjoint(diagnosis.held_out_runs)


def held(diagnosis: Diagnosis) -> str:
    """Return what judges: "held-out runs", or "held-out part" of the only one."""
    return "held-out part" if of_one(diagnosis) else "held-out runs"


def unfitted(diagnosis: Diagnosis) -> str:
    """Return the same as "runs that were not fitted", or "a part that was not fitted"."""
    return "a part that was not fitted" if of_one(diagnosis) else "runs that were not fitted"


def torque_unit(diagnosis: Diagnosis) -> str:
    """Return "N m", or "N" for a prismatic axis."""
    return unit_at("N m", _kind(diagnosis))


def effort(diagnosis: Diagnosis) -> str:
    """Return "torque", or "force" for a prismatic axis."""
    return "force" if _kind(diagnosis) == "prismatic" else "torque"


def position_unit(diagnosis: Diagnosis) -> str:
    """Return "rad", or "m" for a prismatic axis."""
    return unit_at("rad", _kind(diagnosis))


def _kind(diagnosis: Diagnosis) -> str:
    arm = diagnosis.models.get("as_given")
    return "revolute" if arm is None else arm.joints[0].kind
