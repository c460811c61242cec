"""The tables and lists of the diagnosis page."""

from __future__ import annotations

import math
from collections.abc import Mapping

from stribeck.effects.registry import effect_named, registry
from stribeck.gap.result import Cause, Diagnosis
from stribeck.model.effect import Effect
from stribeck.report import words
from stribeck.report.candidates_order import ranked
from stribeck.report.equation import equation_image
from stribeck.report.numbers import (
    estimate,
    interval,
    number,
    percent_interval,
    probability,
    unit_text,
    with_unit,
)
from stribeck.report.page import Bullets, Facts, Law, Laws, Row, Table
from stribeck.report.symptom import symptom_picture

LISTED_RUNS = 20
LAST = ", the last part of it"


def stage_table(diagnosis: Diagnosis) -> Table:
    """Return the gap at every stage, per joint."""
    torque, motion = words.torque_unit(diagnosis), words.position_unit(diagnosis)
    moving = any(stage.motion for stage in diagnosis.stages)
    names = [words.clean(joint) for joint in diagnosis.joints]
    columns = ["stage", *(f"{name} {words.effort(diagnosis)}, {unit_text(torque)}" for name in names)]
    columns += [f"{name} motion, {unit_text(motion)}" for name in names] if moving else []
    rows = []
    for stage in diagnosis.stages:
        metrics = [stage.torque, stage.motion] if moving else [stage.torque]
        cells = [_cell(metric.get(joint)) for metric in metrics for joint in diagnosis.joints]
        last = words.last_stage(diagnosis)
        mark = "strong" if diagnosis.named and stage.stage == last != "retuned" else ""
        rows.append(Row((words.stage(stage.stage), *cells), "muted" if stage.stage == "noise_floor" else mark))
    horizon = with_unit(diagnosis.horizon, "s", 2)
    note = f"Root mean square on the {words.held(diagnosis)}; motion is simulated for {horizon} from recorded states."
    note += " Its noise floor is the encoder's alone, which none reaches: what the drive's noise does adds up." * moving
    return Table("The gap, stage by stage", tuple(columns), tuple(rows), frozenset(range(1, len(columns))), note)


def cause_table(diagnosis: Diagnosis) -> Table:
    """Return every cause with the probability that it is there and its share; only those marked strong are claims."""
    rows = []
    for cause in diagnosis.causes:
        own = cause.effect not in ("none", "unknown")
        name = {"none": "no unmodelled effect", "unknown": "unknown effect"}.get(
            cause.effect, words.effect(cause.effect)
        )
        cells = (
            name,
            words.listing([words.clean(joint) for joint in cause.joints], "or" if cause.anywhere else "and")
            if own
            else "",
            probability(cause.presence) if cause.presence is not None else "",
            probability(cause.probability),
            words.listing([words.effect(other) for other in cause.equivalent if other != cause.effect]),
            _closes(cause),
        )
        rows.append(Row(cells, "strong" if is_named(diagnosis, cause) else "muted"))
    columns = ("effect", "at", "is there", "share", "cannot be told from", "closes")
    note = (
        "Bold: named. Is there: the probability of this effect by itself, beside whatever else acts. Shares (in the "
        "JSON, “probability”) sum to one with “unknown”, an effect outside the list: effects that act together share "
        "it by how many times each makes less of what is left, in logarithms and over all joints, not by what it "
        "closes; those that the records show by themselves take even parts."
        if diagnosis.named
        else "None of these is named: the probabilities say what was considered, not what was found."
    )
    return Table("Causes and their probability", columns, tuple(rows), frozenset({2, 3, 5}), note)


def _closes(cause: Cause) -> str:
    """Return what a cause closes of the gap; in words where no torque was asked for it."""
    known = registry().get(cause.effect)
    if known is not None and known.direct:
        return "seen in the records"
    return percent_interval(cause.closes) if cause.closes else ""


def parameter_table(diagnosis: Diagnosis) -> Table | None:
    """Return the parameters of the named effects with their 95 % intervals; None where nothing is named."""
    rows = tuple(
        Row(
            (
                words.effect(cause.effect),
                words.clean(joint),
                words.clean(key),
                estimate(value),
                interval(value),
                unit_text(value.unit),
            )
        )
        for cause in diagnosis.causes
        if is_named(diagnosis, cause)
        for joint, values in cause.parameters.items()
        for key, value in values.items()
    )
    columns = ("effect", "at", "parameter", "value", "95 % interval", "unit")
    return Table("Parameters of the named effects", columns, rows, frozenset({3, 4})) if rows else None


def is_named(diagnosis: Diagnosis, cause: Cause) -> bool:
    """Return whether the tool commits to this very cause, joints included."""
    return cause.effect in diagnosis.named and cause == words.cause_of(diagnosis, cause.effect)


def search_path(diagnosis: Diagnosis) -> Bullets:
    """Return one sentence per step of the search."""
    steps = sorted({row.step for row in diagnosis.candidates})
    items = tuple(_step(diagnosis, step) for step in steps)
    if items:
        over = ", multiplied over the joints" if len(diagnosis.joints) > 1 else ""
        items += (f"What one gains is the part of the squared residual that is gone on held-out data{over}.",)
    return Bullets("The search", items or ("No effect was tried: the re-tuned model already reaches the noise floor.",))


def _step(diagnosis: Diagnosis, step: int) -> str:
    rows = ranked(diagnosis, step)
    total = sum(row.step == step for row in diagnosis.candidates)
    chosen = [row for row in rows if row.chosen]
    others = [row for row in rows if not row.chosen][:1]
    head = f"Step {step}, {total} candidate{'s' * (total != 1)}: "
    said = [
        f"{_who(row.effect, row.joint)} gains {percent_interval(row.gain)}, t = {number(row.t, 2)}"
        for row in chosen + others
    ]
    if not said:
        return f"{head}all were screened out."
    if not chosen:
        return f"{head}nothing was added; the best, {said[0]}."
    end = f"; next best, {said[1]}." if others else "."
    return f"{head}{said[0]}, {words.chosen(diagnosis, chosen[0].effect)}{end}"


def _who(effect: str, joint: str) -> str:
    return f"{words.effect(effect)} at {words.clean(joint)}" if joint else words.effect(effect)


def next_experiment(diagnosis: Diagnosis) -> Facts | None:
    """Return what to record next to tell apart what these data cannot; None where there is nothing."""
    if not diagnosis.next_experiment:
        return None
    told = dict(diagnosis.next_experiment)
    gain = told.pop("expected_gain", None)
    pairs = [(words.clean(key).replace("_", " "), _plain(value)) for key, value in told.items() if value != []]
    if isinstance(gain, dict):
        pairs.append(("expected gain", _promise(gain)))
    return Facts("The next experiment", tuple(pairs))


def _promise(gain: Mapping[str, float]) -> str:
    """Return what the next experiment promises as a sentence."""
    apart, classic, random = (_deviations(gain[key]) for key in ("t", "t_d_optimal", "t_random"))
    return (
        f"The likeliest, if it is true, comes out {apart} standard deviations from the next one (by a D-optimal motion "
        f"{classic}, by one at random {random}); whichever it is, that is told with probability "
        f"{probability(gain['probability_resolved'])}."
    )


def _deviations(t: float) -> str:
    return "less than 0.1" if t < 0.1 else number(t)


def laws(diagnosis: Diagnosis) -> Laws | None:
    """Return the laws of the named effects and of those that cannot be told from them."""
    wanted = dict.fromkeys(
        name for named in diagnosis.named for name in (named, *words.cause_of(diagnosis, named).equivalent)
    )
    known = [effect for name in wanted if name in registry() for effect in _laws_of(diagnosis, name)]
    if not known:
        return None
    return Laws("What these effects are", tuple(_law(effect) for effect in known))


def _laws_of(diagnosis: Diagnosis, name: str) -> list[Effect]:
    """Return the laws that a family was named with, its first where it was not named."""
    chosen = dict.fromkeys(words.cause_of(diagnosis, name).law.values())
    return [effect_named(name, law) for law in chosen] or [registry()[name]]


def _law(effect: Effect) -> Law:
    name = words.effect(effect.name) + (f" ({words.effect(effect.law)})" if effect.law else "")
    image = equation_image(effect.equation)
    first = registry()[effect.name]
    drawn = words.effect(first.law) if effect.law != first.law else ""
    return Law(name, effect.equation, image, effect.symptom, effect.source, symptom_picture(effect), drawn)


def method(diagnosis: Diagnosis, version: str) -> Facts:
    """Return how the answer was reached."""
    settings = [_setting(key, value) for key, value in diagnosis.settings.items() if not key.startswith("horizon")]
    pairs = [
        ("fitted to", _runs(diagnosis.fit_runs)),
        ("judged on (held out)", _runs(diagnosis.held_out_runs) + (LAST if words.of_one(diagnosis) else "")),
        ("horizon of the motion gap", with_unit(diagnosis.horizon, "s", 2)),
        *settings,
        *(("note", words.clean(note)) for note in diagnosis.notes),
        ("stribeck", version),
    ]
    return Facts("How it was done", tuple(pairs))


def _setting(key: str, value: float | str) -> tuple[str, str]:
    """Return name and value, the unit moved from the name ("cutoff_hz") to the value ("32.3 Hz")."""
    name, _, last = words.clean(key).rpartition("_")
    unit = {"hz": "Hz", "s": "s"}.get(last, "")
    if unit and name and isinstance(value, (int, float)):
        return name.replace("_", " "), with_unit(float(value), unit)
    return words.clean(key).replace("_", " "), _plain(value)


def _runs(names: tuple[str, ...]) -> str:
    more = len(names) - LISTED_RUNS
    return ", ".join(words.clean(name) for name in names[:LISTED_RUNS]) + (f" and {more} more" if more > 0 else "")


def _cell(value: float | None) -> str:
    return "–" if value is None or math.isnan(value) else number(value)


def _plain(value: object) -> str:
    if isinstance(value, dict) and set(value) == {"value", "unit"}:
        return f"{_plain(value['value'])} {unit_text(str(value['unit']))}"
    if isinstance(value, dict):
        return "; ".join(f"{words.clean(key)} {_plain(item)}" for key, item in value.items())
    if isinstance(value, (list, tuple)):
        return ", ".join(_effect_at(str(item)) for item in value)
    if isinstance(value, float):
        return f"{value:.6g}"
    return words.clean(value)


def _effect_at(name: str) -> str:
    """Return an effect that is to be told apart as words; its joint keeps its name: "delay at x_axis"."""
    effect, at, joint = name.partition(" at ")
    return f"{words.effect(effect)}{at}{words.clean(joint)}"
