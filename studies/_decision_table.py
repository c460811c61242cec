"""The table of all rules: what each names in the cases of a batch, set against the key."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from _decision_fits import diagnosis_of
from _decision_rules import DOMAINS, RULES, gains_in_motion

from stribeck.blind.key import Opened
from stribeck.blind.outcome import outcome
from stribeck.blind.rates import rate

SHIPPED = "shipped"
Answer = Mapping[str, Any]


def table(opened: Opened) -> dict[str, Any]:
    """Return one row a rule and domain, shares with 95 % intervals (Wilson 1927), and which row is best."""
    pairs = [(rule, domain) for rule in RULES for domain in DOMAINS if (rule, domain) not in NOT_DEFINED]
    pairs += [(SHIPPED, "torque"), (SHIPPED, "both")]
    methods = [{"rule": rule, "domain": domain, **_judged(opened, rule, domain)} for rule, domain in pairs]
    net = [(row["right"]["value"] or 0.0) - row["wrong"]["value"] for row in methods]
    best = [[row["rule"], row["domain"]] for row, value in zip(methods, net, strict=True) if value > max(net) - 1e-9]
    seconds = sorted(answer["processor_seconds"] for answer in opened.answers.values())
    return {
        "digest": opened.digest,
        "cases": len(opened.answers),
        "methods": methods,
        "best": best,
        "processor_seconds_a_case": seconds[len(seconds) // 2],
        "failed": sum("error" in answer for answer in opened.answers.values()),
    }


NOT_DEFINED = {("block score", "motion"), ("block score", "both")}  # simulated motion has no score


def _judged(opened: Opened, rule: str, domain: str) -> dict[str, Any]:
    library = opened.settings["library"]
    rows = [
        outcome(opened.truths[name], said_by(answer, rule, domain), library) for name, answer in opened.answers.items()
    ]
    kinds = {kind: [row for row in rows if row["kind"] == kind] for kind in ("single", "none", "outside")}
    single = kinds["single"]
    return {
        "top1": rate(row["first"] for row in single),
        "class": rate(row["class"] for row in single),
        "class_strong": rate(row["class"] for row in single if row["bin"] == "strong"),
        "class_fair": rate(row["class"] for row in single if row["bin"] == "fair"),
        "wrong_name": rate(bool(row["extra"]) for row in single),
        "false_alarm": rate(bool(row["extra"]) for row in kinds["none"]),
        "silent_outside": rate(not row["extra"] for row in kinds["outside"]),
        "right": rate(bool(row["found"]) and not row["extra"] for row in single),
        "wrong": rate(bool(row["extra"]) for row in rows),
    }


def said_by(answer: Answer, rule: str, domain: str) -> Answer:
    """Return an answer as a rule would have given it; a case that could not be searched stays a failure."""
    if "error" in answer:
        return answer
    fits, shipped = answer["fits"], answer["diagnosis"]
    if rule == SHIPPED:
        return answer if domain == "torque" or _confirmed(fits, shipped) else {**answer, "diagnosis": diagnosis_of([])}
    k = RULES[rule](fits, domain) if fits["rivals"] else 0
    return {**answer, "diagnosis": diagnosis_of([_named(fits, k)] if k else [])}


def _named(fits: Mapping[str, Any], k: int) -> tuple[str, str, Sequence[str]]:
    effect, joint = fits["rivals"][k - 1]
    return effect, joint, list(dict.fromkeys(fits["rivals"][i - 1][0] for i in (k, *fits["twins"][k - 1])))


def _confirmed(fits: Mapping[str, Any], shipped: Mapping[str, Any]) -> bool:
    """Return whether the first name's model simulates the held-out runs better than the one without."""
    if not shipped["causes"]:
        return True
    first = shipped["causes"][0]
    place = [first["effect"], first["joints"][0]]
    return place not in fits["rivals"] or gains_in_motion(fits, fits["rivals"].index(place) + 1)


def in_words(result: Mapping[str, Any]) -> list[str]:
    """Return the table as lines of text."""
    heads = ("top1", "class", "wrong_name", "false_alarm", "silent_outside", "right", "wrong")
    lines = [f"{'rule':18}{'residual':9}" + "".join(f"{head:>16}" for head in heads)]
    for row in result["methods"]:
        cells = "".join(f"{row[head]['k']:>11}/{row[head]['n']:<4}" for head in heads)
        lines.append(f"{row['rule']:18}{row['domain']:9}{cells}")
    return lines
