"""The score of many answers: shares with their intervals, calibration, confusion, limits, and what was asked for."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from statistics import median
from typing import Any, TypeAlias

from stribeck.blind.key import Opened
from stribeck.blind.outcome import STRENGTHS, outcome, strength_bin
from stribeck.blind.rates import calibration, detection_limit, rate
from stribeck.version import package_version
from stribeck.withheld.plan import LEVELS

Row: TypeAlias = Mapping[str, Any]
Measure: TypeAlias = Callable[[Sequence[Row]], dict[str, Any]]
SCHEMA = "stribeck.withheld-score/1"
POINTS = 0.05  # by which a claimed shrinkage may miss the true one


def score(opened: Opened, shrinkage: Mapping[str, Row] | None = None) -> dict[str, Any]:
    """Return the content of ``score.json``.

    Parameters
    ----------
    opened : Opened
        Answers and truths.
    shrinkage : mapping or None
        By case, ``claimed`` and ``true`` part of the closable gap that the named effects close
        (:func:`stribeck.blind.shrinkage.true_shrinkage`).
    """
    library = opened.settings["library"]
    rows = [
        {"case": name, **outcome(opened.truths[name], answer, library), **(shrinkage or {}).get(name, {})}
        for name, answer in opened.answers.items()
    ]
    names = ("single", "pair", "several", "none", "outside")
    kinds = {kind: [row for row in rows if row["kind"] == kind] for kind in names}
    result = {
        "schema": SCHEMA,
        "version": package_version(),
        "units": {
            "strength": "effect torque over noise floor",
            "strength_left": "what re-tuning within the tolerances leaves of it, over noise floor",
            "seconds": "s",
        },
        "digest": opened.digest,
        "code": opened.settings["code"],
        "sources": len({answer["code"] for answer in opened.answers.values()}),
        "library": library,
        "cases": len(rows),
        "failed": rate(row["error"] is not None for row in rows),
        "single": _by_strength(kinds["single"], _named),
        "single_left": _by_strength_left(kinds["single"], _named),
        "single_levels": _by_level(kinds["single"]),
        "none": _quiet(kinds["none"]),
        "outside": _outside(kinds["outside"]),
        "pairs": _by_strength(kinds["pair"], _both),
        "pairs_left": _by_strength_left(kinds["pair"], _both),
        "several": _several(kinds["several"]),
        "calibration": _calibrated(rows),
        "intervals": _intervals(rows),
        "shrinkage": _shrinkage(rows),
        "effects": _effects(kinds["single"]),
        "confusion": _confusion([row for row in rows if row["kind"] not in ("pair", "several")]),
        "time": {
            "median": _median(row["seconds"] for row in rows),
            "longest": max(row["seconds"] for row in rows),
            "processor_median": _median(row["processor_seconds"] for row in rows),
        },
        "rows": rows,
    }
    return {**result, "targets": targets(result)}


def _by_strength(rows: Sequence[Row], measure: Measure, key: str = "bin") -> dict[str, Any]:
    bins = {name: measure([row for row in rows if row[key] == name]) for _, name in STRENGTHS}
    return {"all": measure(rows), **bins}


def _by_strength_left(rows: Sequence[Row], measure: Measure) -> dict[str, Any] | None:
    """Return the same by what re-tuning leaves of the strength; None where the key does not record it."""
    return None if any(row["bin_left"] is None for row in rows) else _by_strength(rows, measure, "bin_left")


def _by_level(rows: Sequence[Row]) -> dict[str, Any]:
    return {level: _named([row for row in rows if row["level"] == level]) for level in LEVELS}


def _named(rows: Sequence[Row]) -> dict[str, Any]:
    judged = {key: [row[key] for row in rows if row[key] is not None] for key in ("joint", "channel")}
    return {
        "top1": rate(row["first"] for row in rows),
        "class": rate(row["class"] for row in rows),
        "named": rate(bool(row["found"]) for row in rows),
        "clean": rate(bool(row["found"]) and not row["extra"] for row in rows),
        "wrong_name": rate(bool(row["extra"]) for row in rows),
        "abstained": rate(not row["named"] for row in rows),
        "class_size": _mean([len(names) for row in rows for names in row["equivalent"].values()]),
        "joint": rate(judged["joint"]),
        "channel": rate(judged["channel"]),
    }


def _both(rows: Sequence[Row]) -> dict[str, Any]:
    return {
        "both": rate(len(row["found"]) == 2 for row in rows),
        "at_least_one": rate(bool(row["found"]) for row in rows),
        "wrong_name": rate(bool(row["extra"]) for row in rows),
    }


def _several(rows: Sequence[Row]) -> dict[str, Any]:
    """Count effects, and names: of arms with many an answer is right in part."""
    effects = [
        (effect, left, row) for row in rows for effect, left in zip(row["effects"], row["each_left"], strict=True)
    ]
    names = [name in row["extra"] for row in rows for name in row["named"]]
    return {
        "found": rate(effect in row["found"] for effect, _, row in effects),
        **{
            name: rate(
                effect in row["found"]
                for effect, left, row in effects
                if left is not None and strength_bin(left) == name
            )
            for _, name in STRENGTHS
        },
        "wrong": rate(names),
        "wrong_name": rate(bool(row["extra"]) for row in rows),
        "none_named": rate(not row["named"] for row in rows),
    }


def _quiet(rows: Sequence[Row]) -> dict[str, Any]:
    """Count false alarms: names where no effect is hidden; under coloured noise a disturbance may be named.

    What failed is none, but no silence either: it counts as one.
    """

    def alarms(some: Sequence[Row]) -> dict[str, Any]:
        return rate(bool(row["extra"] or row["error"]) for row in some)

    return {
        "false_alarms": alarms(rows),
        "undisturbed": alarms([row for row in rows if not row["disturbed"]]),
        "disturbed": alarms([row for row in rows if row["disturbed"]]),
        "no_gap": rate(row["verdict"] == "no_gap" for row in rows),
    }


def _outside(rows: Sequence[Row]) -> dict[str, Any]:
    def silent(some: Sequence[Row]) -> dict[str, Any]:
        return rate(not row["extra"] and not row["error"] for row in some)

    effects = sorted({name for row in rows for name in row["effects"]})
    return {
        "abstained": silent(rows),
        **{why: silent([row for row in rows if row["why"] == why]) for why in ("unknown", "left_out", "not_held")},
        "effects": {name: silent([row for row in rows if name in row["effects"]]) for name in effects},
    }


def _calibrated(rows: Sequence[Row]) -> dict[str, Any]:
    """Calibration of the likeliest statement of each answer (the headline), and of all statements."""
    top = [tuple(row["statements"][0][:2]) for row in rows if row["statements"]]
    every = [tuple(item[:2]) for row in rows for item in row["statements"]]
    return {"likeliest": calibration(top), "every": calibration(every)}


def _intervals(rows: Sequence[Row]) -> dict[str, Any]:
    """Return the coverage of the intervals whose law plant and library share, and that of every parameter."""
    found = [item for row in rows for item in row["intervals"]]
    keys = ("effect", "name", "same_law")
    kinds: dict[tuple[Any, ...], list[bool]] = {}
    for item in found:
        kinds.setdefault(tuple(item[key] for key in keys), []).append(item["inside"])
    each = [
        {"effect": effect, "parameter": name, "same_law": same, **rate(inside)}
        for (effect, name, same), inside in sorted(kinds.items())
    ]
    same = [item["inside"] for item in found if item["same_law"]]
    return {"coverage": rate(same), "parameters": each}


def _shrinkage(rows: Sequence[Row]) -> dict[str, Any]:
    pairs = [(row["claimed"], row["true"]) for row in rows if row.get("true") is not None]
    return {
        "within_5_points": rate(abs(claimed - true) <= POINTS for claimed, true in pairs),
        "median_error": _median(abs(claimed - true) for claimed, true in pairs),
        "bias": _median(claimed - true for claimed, true in pairs),
        "median_true": _median(true for _, true in pairs),
    }


def _effects(rows: Sequence[Row]) -> dict[str, Any]:
    result = {}
    for name in sorted({row["effects"][0] for row in rows}):
        own = [row for row in rows if row["effects"] == [name]]
        result[name] = {
            **_named(own),
            "detection_limit": _limit(own, "strength"),
            "detection_limit_left": _limit(own, "strength_left"),
        }
    return result


def _limit(rows: Sequence[Row], key: str) -> dict[str, Any] | None:
    if any(row[key] is None for row in rows):
        return None
    return detection_limit([row[key] for row in rows], [bool(row["found"]) for row in rows])


def _confusion(rows: Sequence[Row]) -> dict[str, Any]:
    """Count what was said (columns) by what was hidden (rows); a name in the right class counts as right.

    So does the name of a disturbance where noise shakes an arm without an effect: nothing that was not there was said.
    """
    counts = Counter((_hidden(row), _said(row)) for row in rows)
    down = _ordered({true for true, _ in counts}, ("left_out", "none"))
    across = _ordered({said for _, said in counts}, ("none", "unknown", "failed"))
    return {"hidden": down, "said": across, "counts": [[counts[true, said] for said in across] for true in down]}


def _said(row: Row) -> str:
    shaken = not row["effects"] and row["named"] and not row["extra"]
    return "none" if shaken else str(row["answer"])


def _ordered(names: set[str], last: Sequence[str]) -> list[str]:
    return [*sorted(names - set(last)), *(name for name in last if name in names)]


def _hidden(row: Row) -> str:
    if not row["effects"]:
        return "none"
    return "left_out" if row["why"] == "left_out" else str(row["effects"][0])


def _median(values: Any) -> float | None:
    given = list(values)
    return float(f"{median(given):.4g}") if given else None


def _mean(values: Sequence[float]) -> float | None:
    return float(f"{sum(values) / len(values):.3g}") if values else None


def targets(result: Row) -> list[dict[str, Any]]:
    """Return what the check is asked to show, what it shows, and whether that holds; null where nothing was tried.

    Shares of cases are told with ``k`` of ``n``.
    """
    single, coverage = result["single"], result["intervals"]["coverage"]["value"]
    lines: list[tuple[str, Row | float | None, float, bool]] = [
        ("named, strength 3 and more", single["strong"]["named"], 0.90, True),
        ("named, strength 1 to 3", single["fair"]["named"], 0.75, True),
        ("wrong name, of all single effects", single["all"]["wrong_name"], 0.03, False),
        ("joint right where one is blamed, strength 3 and more", single["strong"]["joint"], 0.95, True),
        ("channel right where one is blamed, strength 3 and more", single["strong"]["channel"], 0.92, True),
        ("false alarms", result["none"]["false_alarms"], 0.03, False),
        ("no wrong name outside the library", result["outside"]["abstained"], 0.90, True),
        ("both of a pair named", result["pairs"]["all"]["both"], 0.75, True),
        ("95 % intervals that hold, off 95 %", None if coverage is None else abs(coverage - 0.95), 0.03, False),
        ("calibration error", result["calibration"]["likeliest"]["ece"], 0.05, False),
        ("claimed less true shrinkage, median size", result["shrinkage"]["median_error"], 0.05, False),
        ("median of the gap closed", result["shrinkage"]["median_true"], 0.85, True),
    ]
    return [_target(*line) for line in lines]


def _target(what: str, found: Row | float | None, want: float, least: bool) -> dict[str, Any]:
    """Return a line of what is asked; a rate has its counts beside it."""
    counts, have = ({"k": found["k"], "n": found["n"]}, found["value"]) if isinstance(found, Mapping) else ({}, found)
    holds = None if have is None else bool(have >= want if least else have <= want)
    return {"what": what, "have": have, **counts, "want": want, "at_least": least, "holds": holds}
