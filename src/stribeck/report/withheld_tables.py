"""The tables of a withheld check: shares with their intervals, by strength, by effect, and case by case."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from stribeck.gap.result import Estimate
from stribeck.report import words
from stribeck.report.figures.withheld import BINS
from stribeck.report.numbers import number, percent, percent_interval
from stribeck.report.page import Row, Table

Score = Mapping[str, Any]
MEASURES = {
    "top1": "named first",
    "class": "in the class named first",
    "named": "named, or in a named class",
    "clean": "and nothing else",
    "wrong_name": "a wrong name",
    "abstained": "no name",
    "joint": "joint right",
    "channel": "stage of the path right",
}
OF_PAIRS = {"both": "both named", "at_least_one": "one at least", "wrong_name": "a wrong name"}
SHARE_LINES = ("calibration error",)  # among what is asked, plain numbers; all others are shares


def share(found: Score) -> str:
    """Return "92 % (85 to 96 %), 46 of 50"; a dash without cases."""
    if not found["n"]:
        return "–"
    return f"{percent_interval(Estimate(found['value'], *found['ci95']))}, {found['k']} of {found['n']}"


def _counted(found: Score) -> str:
    """Return "3 of 4 (30 to 95 %)": of a few cases the count says more than the share, and a table has little room."""
    if not found["n"]:
        return "–"
    value = percent_interval(Estimate(found["value"], *found["ci95"]))
    return f"{found['k']} of {found['n']} {value[value.index('(') :]}"


def asked(score: Score) -> Table:
    """Return what the check is asked to show beside what it shows."""
    rows = []
    for line in score["targets"]:
        have, limit = _shown(line)
        verdict = {True: "holds", False: "does not hold", None: ""}[line["holds"]]
        rows.append(Row((line["what"], limit, have, verdict), "flag" if line["holds"] is False else ""))
    return Table("What is asked, and what holds", ("", "asked", "measured", ""), tuple(rows), frozenset({1, 2}))


def told(line: Score) -> str:
    """Return a line of what is asked for the terminal: "false alarms: 0 of 4 (0 %; at most 3.0 % asked)"."""
    have, limit = _shown(line)
    if "n" in line:
        return f"{line['what']}: {line['k']} of {line['n']} ({percent(line['have'])}; {limit} asked)"
    return f"{line['what']}: {have} ({limit} asked)"


def _shown(line: Score) -> tuple[str, str]:
    """Return what a line of what is asked has, with its counts where it has any, and what is asked."""
    show = (lambda x: number(x, 2)) if line["what"] in SHARE_LINES else percent
    have = "not tried" if line["have"] is None else show(line["have"])
    if line.get("n"):
        have = f"{have}, {line['k']} of {line['n']}"
    return have, f"{'at least' if line['at_least'] else 'at most'} {show(line['want'])}"


def by_strength(score: Score) -> list[Table]:
    """Return what was named, where and how wrongly, by strength, by what re-tuning leaves of it, and by level."""
    single, left, levels = score["single"], score.get("single_left"), score.get("single_levels")
    if not single["all"]["named"]["n"]:
        return []
    unknown = "What re-tuning within the tolerances leaves of the strength is not recorded in this key."
    bins = {**BINS, "all": "all"}
    made = [_measured("Single effects by strength", single, bins, "" if left else unknown)]
    if left:
        note = "Strength: what re-tuning within the stated tolerances leaves of the effect's torque, over noise floor."
        made.append(_measured("The same by the strength that re-tuning leaves", left, bins, note))
    if levels:
        note = "The level is a share of the torque that moves the joint, whatever the noise floor."
        made.append(_measured("The same by severity", levels, {name: name for name in levels}, note))
    return made


def pairs(score: Score) -> Table | None:
    """Return what was named of two effects in one arm, by the strength of the weaker one."""
    found = score["pairs"]
    if not found["all"]["both"]["n"]:
        return None
    note = "Strength: that of the weaker of the two effects."
    return _measured("Two effects by strength", found, {**BINS, "all": "all"}, note, OF_PAIRS)


def several(score: Score) -> Table | None:
    """Return what was named in arms with three to five effects, effect by effect and name by name."""
    found = score["several"]
    if not found["found"]["n"]:
        return None
    rows = (
        ("effects named", found["found"]),
        *((f"effects named, strength {text}", found[name]) for name, text in BINS.items()),
        ("names that are wrong", found["wrong"]),
        ("cases with a wrong name", found["wrong_name"]),
        ("cases without a name", found["none_named"]),
    )
    note = "Strength: what re-tuning within the stated tolerances leaves of each effect's torque, over noise floor."
    made = tuple(Row((text, _counted(counts))) for text, counts in rows)
    return Table("Three to five effects in one arm", ("", "of all"), made, frozenset({1}), note)


def _measured(
    title: str, found: Score, columns: Mapping[str, str], note: str, measures: Mapping[str, str] = MEASURES
) -> Table:
    rows = [Row((text, *(_counted(found[name][key]) for name in columns))) for key, text in measures.items()]
    return Table(title, ("cases", *columns.values()), tuple(rows), frozenset(range(1, 1 + len(columns))), note)


def effect_by_effect(score: Score) -> Table | None:
    """Return what was named, where, and the detection limits, by hidden effect."""
    if not score["effects"]:
        return None
    rows = []
    for name, row in score["effects"].items():
        limits = (_limit(row["detection_limit"]), _limit(row.get("detection_limit_left")))
        counted = (_count(row[what]) for what in ("clean", "wrong_name", "joint", "channel"))
        rows.append(Row((words.effect(name), _counted(row["named"]), *counted, *limits)))
    columns = ("effect", "named", "nothing else", "wrong name", "joint", "stage", "limit", "left")
    note = (
        "Cases, with the 95 % interval of their share (Wilson); joint and stage of the path: right, where one is "
        "blamed. The limit is the strength at which half are named, left the same by what re-tuning leaves of the "
        "strength (–: not recorded, or fewer than four cases)."
    )
    return Table("Effect by effect", columns, tuple(rows), frozenset(range(1, 8)), note)


def _count(found: Score) -> str:
    return f"{found['k']} of {found['n']}" if found["n"] else "–"


def _limit(limit: Score | None) -> str:
    if not limit:
        return "–"
    return {"below": "< ", "above": "> "}.get(limit["outside"] or "", "") + number(limit["strength"], 2)


def outside(score: Score) -> Table | None:
    """Return how often no wrong name was given where the effect is in no library."""
    found = score["outside"]
    if not found["abstained"]["n"]:
        return None
    rows = [Row((words.effect(name), share(row))) for name, row in found["effects"].items()]
    return Table("Effects outside the library", ("hidden", "no wrong name"), tuple(rows), frozenset({1}))


def intervals(score: Score) -> Table | None:
    """Return how often 95 % intervals hold, by parameter."""
    rows = [
        Row((words.effect(row["effect"]), words.clean(row["parameter"]), share(row)),
            ("flag" if row["ci95"][1] < 0.95 else "") if row["same_law"] else "muted")
        for row in score["intervals"]["parameters"]
    ]  # fmt: skip
    if not rows:
        return None
    note = (
        "Parameters that plant and library mean alike; flagged where fewer than 95 % is more than chance. Grey: the "
        "plant has another law under that name, so that these are not counted above."
    )
    return Table(
        "95 % intervals that hold the true value", ("effect", "parameter", "hold"), tuple(rows), frozenset({2}), note
    )


def failures(score: Score) -> Table | None:
    """Return the cases with a wrong name or an error."""
    rows = [
        Row((row["case"], " and ".join(words.effect(e) for e in row["effects"]) or "nothing",
             *("–" if value is None else number(value, 2) for value in (row["strength"], row.get("strength_left"))),
             words.listing([words.effect(name) for name in row["extra"]]) or words.short(row["error"] or "", 80)))
        for row in score["rows"] if row["extra"] or row["error"]
    ]  # fmt: skip
    if not rows:
        return None
    columns = ("case", "hidden", "strength", "left", "wrongly said")
    return Table("Cases that went wrong", columns, tuple(rows), frozenset({2, 3}))
