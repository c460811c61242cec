"""One answer against one truth: what was right, what was wrong, and what was claimed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any, TypeAlias

import numpy as np
from scipy.optimize import linear_sum_assignment

from stribeck.blind.comparable import same_law, true_values

Json: TypeAlias = Mapping[str, Any]

STRENGTHS = ((3.0, "strong"), (1.0, "fair"), (0.0, "faint"))  # from each strength on: >= 3, 1 to 3, < 1
# Of effects that the recording plant has and a library may lack as well; the contract's table
CHANNELS = {
    "asymmetric_friction": "friction", "negative_damping": "friction", "presliding": "friction",
    "frictional_lag": "friction", "dwell_time": "friction", "history": "friction",
    "position_dependent_friction": "friction", "load_dependent_friction": "friction", "quadratic_damping": "friction",
    "actuator_lag": "actuator", "delay": "actuator", "torque_gain": "actuator", "torque_offset": "actuator",
    "torque_saturation": "actuator", "torque_dead_zone": "actuator", "cogging": "actuator", "torque_ripple": "actuator",
    "joint_flexibility": "transmission", "backlash": "transmission",
    "encoder_eccentricity": "sensing", "encoder_offset": "sensing", "encoder_quantisation": "sensing",
    "velocity_filter": "sensing", "time_shift": "sensing",
    "payload": "rigid_body", "gravity_tilt": "rigid_body", "base_flexibility": "rigid_body",
    "cable_spring": "external", "contact": "external", "input_disturbance": "external",
}  # fmt: skip
WHOLE_ARM = frozenset({"gravity_tilt", "base_flexibility"})  # in no joint
DISTURBANCE = "input_disturbance"


def outcome(truth: Json, answer: Json, library: Sequence[str]) -> dict[str, Any]:
    """Return what one answer is worth.

    Parameters
    ----------
    truth : mapping
        The case's entry in the key.
    answer : mapping
        The case's file among the answers.
    library : sequence of str
        Effects that were candidates, before what the case itself withheld.

    Returns
    -------
    dict
        ``kind``: ``single``, ``pair`` or ``several`` (all effects in the library), ``none``, or ``outside`` (an effect
        is not, with ``why``: ``unknown`` to any library, ``left_out`` or ``not_held``); ``first`` (the first named
        effect is the hidden one), ``class`` (or lists it as equivalent), ``found`` (hidden effects in the class of a
        named one, each of a name of its own), ``extra`` (names in whose class nothing hidden is), ``answer`` for the
        confusion matrix, ``statements`` (probability, whether so), ``joint`` and ``channel`` right or not (null:
        nothing to judge), ``intervals``. ``strength`` with its ``bin`` is that of the weakest hidden effect,
        ``strength_left`` with its ``bin_left`` what re-tuning within the tolerances leaves of it (null: not recorded
        in the key), and ``each_left`` that of every one.
    """
    row: dict[str, Any] = {"kind": _kind(truth, answer, library), "why": _why(truth, answer, library)}
    row |= {"effects": [e["effect"] for e in truth["effects"]], "disturbed": bool(truth["disturbances"])}
    row["joints"] = [e["joint"] for e in truth["effects"]]
    row["strength"] = min((e["strength"] for e in truth["effects"]), default=None)
    row["bin"] = None if row["strength"] is None else strength_bin(row["strength"])
    left = [e.get("strength_left") for e in truth["effects"]]  # older keys have none
    row["each_left"] = left
    row["strength_left"] = min((s for s in left if s is not None), default=None) if None not in left else None
    row["bin_left"] = None if row["strength_left"] is None else strength_bin(row["strength_left"])
    row |= {
        "level": truth["level"],
        "seconds": answer["seconds"],
        "processor_seconds": answer["processor_seconds"],
        "error": answer.get("error"),
    }
    if "error" in answer:
        return row | _nothing()
    return row | _judged(truth, answer["diagnosis"], answer, library)


def strength_bin(strength: float) -> str:
    """Return ``strong`` (effect torque at least 3 noise floors), ``fair`` (at least 1) or ``faint``."""
    return next(name for least, name in STRENGTHS if strength >= least)


def _nothing() -> dict[str, Any]:
    silent = {
        "named": [],
        "equivalent": {},
        "found": [],
        "extra": [],
        "first": False,
        "class": False,
        "answer": "failed",
        "verdict": None,
    }
    return {**silent, "statements": [], "joint": None, "channel": None, "intervals": [], "closed": None}


def _judged(truth: Json, found: Json, answer: Json, library: Sequence[str]) -> dict[str, Any]:
    causes = {cause["effect"]: cause for cause in found["causes"]}
    named = [causes[name] for name in found["named"]]
    true = [e for e in truth["effects"] if held(e, answer, library)]
    names = {e["effect"] for e in true}
    accepted = names | accepted_beside(truth)
    hits = {e["effect"]: [c for c in named if e["effect"] in class_of(c)] for e in true}
    shown = [e["effect"] for e in truth["effects"]]
    return {
        "named": [c["effect"] for c in named],
        "equivalent": {c["effect"]: list(class_of(c)) for c in named},
        "found": _found([e["effect"] for e in true], named),
        "extra": [c["effect"] for c in named if not accepted & set(class_of(c))],
        "first": bool(named) and named[0]["effect"] in names,
        "class": bool(named) and bool(names & set(class_of(named[0]))),
        "answer": _answer(shown, named, found),
        "verdict": found["verdict"],
        "statements": _statements(found, truth, names, accepted),
        "joint": _joint(true, hits, found),
        "channel": _channel(true, found),
        "intervals": [row for e in true for c in hits[e["effect"]] for row in _intervals(c, e)],
        "closed": None if found["gap"]["closed"] is None else found["gap"]["closed"]["value"],
    }


def _found(true: Sequence[str], named: Sequence[Json]) -> list[str]:
    """Return as many hidden effects as there are names for, one to one; an effect's own name goes to it first."""
    worth = np.zeros((len(true), len(named)))
    for (i, name), (k, c) in product(enumerate(true), enumerate(named)):
        if name in class_of(c):
            worth[i, k] = 1.0 + (name == c["effect"]) / (1 + len(true))
    return [true[i] for i, k in zip(*linear_sum_assignment(worth, maximize=True), strict=True) if worth[i, k]]


def class_of(cause: Json) -> tuple[str, ...]:
    """Return the names that a cause stands for: its own and those that the data cannot tell from it."""
    return tuple(dict.fromkeys((cause["effect"], *cause["equivalent"])))


def held(effect: Json, answer: Json, library: Sequence[str]) -> bool:
    """Whether the library could name a hidden effect: coloured noise has no law in it, whatever its name."""
    coloured = effect["effect"] == DISTURBANCE and effect["parameters"].get("amplitude") == 0.0
    return effect["effect"] in library and effect["effect"] not in answer["leave_out"] and not coloured


def accepted_beside(truth: Json) -> set[str]:
    """Return names that are no error although no law of that name is hidden: coloured noise is a disturbance."""
    every = (*truth["effects"], *truth["disturbances"])
    return {DISTURBANCE} if any(e["effect"] == DISTURBANCE for e in every) else set()


def _kind(truth: Json, answer: Json, library: Sequence[str]) -> str:
    if not truth["effects"]:
        return "none"
    if not all(held(e, answer, library) for e in truth["effects"]):
        return "outside"
    return {1: "single", 2: "pair"}.get(len(truth["effects"]), "several")


def _why(truth: Json, answer: Json, library: Sequence[str]) -> str | None:
    if _kind(truth, answer, library) != "outside":
        return None
    if not truth["known"]:
        return "unknown"
    return "left_out" if any(e["effect"] in answer["leave_out"] for e in truth["effects"]) else "not_held"


def _answer(true: Sequence[str], named: Sequence[Json], found: Json) -> str:
    """Return the column of the confusion matrix: a hidden effect where its class is named, else the first name."""
    for name in true:
        if any(name in class_of(c) for c in named):
            return name
    if named:
        return str(named[0]["effect"])
    return "none" if found["verdict"] == "no_gap" else "unknown"


def _statements(found: Json, truth: Json, names: set[str], accepted: set[str]) -> list[list[Any]]:
    """Return (probability, whether so, effect) of every cause, the likeliest first.

    A cause states the probability that it (or its class) is there at all; ``unknown`` that something is there that
    no effect of the library explains, ``none`` that nothing is. Under coloured noise either may be said.
    """
    something = any(e["effect"] not in names for e in (*truth["effects"], *truth["disturbances"]))
    nothing = not truth["effects"]
    rows = []
    for cause in found["causes"]:
        stated = cause.get("presence", cause["probability"])
        if cause["effect"] == "unknown":
            so = something
        elif cause["effect"] == "none":
            so = nothing
        else:
            so = bool(accepted & set(class_of(cause)))
        if stated is not None:
            rows.append([float(min(max(stated, 0.0), 1.0)), bool(so), cause["effect"]])
    return sorted(rows, key=lambda row: -row[0])


def _joint(true: Sequence[Json], hits: Mapping[str, Sequence[Json]], found: Json) -> bool | None:
    """Whether the right joint is blamed, and alone: by the name where one is right, else by the largest share."""
    # a wall in the plane, which has a direction, pushes at all of them
    single = [e for e in true if e["effect"] not in WHOLE_ARM and "direction" not in e["parameters"]]
    if len(single) != 1 or len(true) != 1:
        return None
    own = hits[single[0]["effect"]]
    if own:
        return list(own[0]["joints"]) == [single[0]["joint"]]
    return bool(found["where"][0]["joint"] == single[0]["joint"]) if found["where"] else None


def _channel(true: Sequence[Json], found: Json) -> bool | None:
    """Whether the largest share of the gap lies in the right stage of the path; null where no stage is blamed."""
    if len(true) != 1 or not found["where"] or found["where"][0]["channel"] == "unknown":
        return None
    return bool(found["where"][0]["channel"] == CHANNELS[true[0]["effect"]])


def _intervals(cause: Json, true: Json) -> list[dict[str, Any]]:
    """Return truth and interval of every parameter, in the right joint, that plant and library mean alike."""
    if cause["effect"] != true["effect"]:
        return []
    own, rows = cause["parameters"].get(true["joint"], {}), []
    same = same_law(true["effect"], true["parameters"], (cause.get("law") or {}).get(true["joint"]))
    for name, value in true_values(true["effect"], true["parameters"]).items():
        if name in own and own[name]["value"] is not None:
            low, high = own[name]["ci95"]
            inside = (low is None or low <= value) and (high is None or value <= high)
            row = {"effect": true["effect"], "name": name, "same_law": same}
            rows.append({**row, "true": value, **own[name], "inside": inside})
    return rows
