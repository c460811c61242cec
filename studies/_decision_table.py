"""The table of all rules: what each names in the cases of a batch, set against the key."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from _decision_fits import diagnosis_of
from _decision_rules import DOMAINS, RULES, Evidence, gains_in_motion

from stribeck.blind.key import Opened
from stribeck.blind.outcome import outcome
from stribeck.blind.rates import rate

SHIPPED = "shipped"
Answer = Mapping[str, Any]


def table(opened: Opened) -> dict[str, Any]:
    """Return one row a rule and domain, shares with 95 % intervals (Wilson 1927), and which row is best."""
    judge = _Judge(opened)
    pairs = [(rule, domain) for rule in RULES for domain in DOMAINS if (rule, domain) not in NOT_DEFINED]
    shipped = [{"rule": SHIPPED, "domain": domain, **_shares(judge.shipped(domain))} for domain in ("torque", "both")]
    most = shipped[0]["wrong"]["k"]
    methods = [*(_row(judge, rule, domain, most) for rule, domain in pairs), *shipped]
    net = [_net(row) for row in methods]
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


class _Judge:
    """What a name is worth in each case of a batch; every name is judged once."""

    def __init__(self, opened: Opened) -> None:
        self.opened = opened
        self._known: dict[tuple[str, int], dict[str, Any]] = {}
        self._weighed: dict[tuple[str, str, str], Evidence | None] = {}

    def rows(self, rule: str, domain: str, threshold: float) -> list[dict[str, Any]]:
        """Return the outcomes of a rule at a threshold."""
        weighed = {name: self._evidence(name, rule, domain) for name in self.opened.answers}
        return [self._row(name, found.named(threshold) if found else 0) for name, found in weighed.items()]

    def shipped(self, domain: str) -> list[dict[str, Any]]:
        """Return the outcomes of the shipped rule."""
        return [self._outcome(name, shipped_in(answer, domain)) for name, answer in self.opened.answers.items()]

    def _evidence(self, name: str, rule: str, domain: str) -> Evidence | None:
        """Return what a rule makes of a case; None where there was nothing to choose from."""
        key, answer = (name, rule, domain), self.opened.answers[name]
        if key not in self._weighed:
            rivals = [] if "error" in answer else answer["fits"]["rivals"]
            self._weighed[key] = RULES[rule].weigh(answer["fits"], domain) if rivals else None
        return self._weighed[key]

    def _row(self, name: str, k: int) -> dict[str, Any]:
        if (name, k) not in self._known:
            self._known[name, k] = self._outcome(name, naming(self.opened.answers[name], k))
        return self._known[name, k]

    def _outcome(self, name: str, answer: Answer) -> dict[str, Any]:
        return outcome(self.opened.truths[name], answer, self.opened.settings["library"])


def _row(judge: _Judge, rule: str, domain: str, most: int) -> dict[str, Any]:
    """Return a rule's shares at its usual threshold, and the best that others give in hindsight.

    ``in_hindsight`` has most right less wrong, ``as_few_wrong`` most right with at most so many wrong (None: none has).
    """
    thresholds = np.union1d(RULES[rule].others, [RULES[rule].usual])
    curve = [{"threshold": float(value), **_shares(judge.rows(rule, domain, value))} for value in thresholds]
    quiet = [row for row in curve if row["wrong"]["k"] <= most]
    return {
        "rule": rule,
        "domain": domain,
        "threshold": RULES[rule].usual,
        **_shares(judge.rows(rule, domain, RULES[rule].usual)),
        "in_hindsight": max(curve, key=_net),
        "as_few_wrong": max(quiet, key=lambda row: row["right"]["k"], default=None),
        "curve": [[row["threshold"], row["right"]["k"], row["wrong"]["k"]] for row in curve],
    }


def _net(row: Mapping[str, Any]) -> float:
    return float((row["right"]["value"] or 0.0) - row["wrong"]["value"])


def _shares(rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
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


def naming(answer: Answer, k: int) -> Answer:
    """Return an answer that names the k-th rival; a case that could not be searched stays a failure."""
    if "error" in answer:
        return answer
    return {**answer, "diagnosis": diagnosis_of([_named(answer["fits"], k)] if k else [])}


def shipped_in(answer: Answer, domain: str) -> Answer:
    """Return what the shipped rule says; for ``both`` the simulation must not speak against its first name."""
    if "error" in answer or domain == "torque" or _confirmed(answer["fits"], answer["diagnosis"]):
        return answer
    return {**answer, "diagnosis": diagnosis_of([])}


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
    """Return the table as lines of text, last what other thresholds give: best, and with as few wrong as shipped."""
    heads = ("top1", "class", "wrong_name", "false_alarm", "silent_outside", "right", "wrong")
    lines = [f"{'rule':18}{'residual':9}" + "".join(f"{head:>15}" for head in heads) + "   in hindsight: right, wrong"]
    for row in result["methods"]:
        cells = "".join(f"{row[head]['k']:>10}/{row[head]['n']:<4}" for head in heads)
        others = [row.get(key) for key in ("in_hindsight", "as_few_wrong")]
        texts = [f"{o['right']['k']}, {o['wrong']['k']} at {o['threshold']:.3g}" for o in others if o is not None]
        lines.append(f"{row['rule']:18}{row['domain']:9}{cells}   {'; '.join(texts)}".rstrip())
    if result["failed"]:
        lines.append(f"{result['failed']} of {result['cases']} cases failed and count as silence")
    return lines
