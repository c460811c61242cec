"""The report of a withheld check: ``report.html`` and its figures, from the content of ``score.json``."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from matplotlib.figure import Figure

from stribeck.gap.result import Estimate
from stribeck.report import words
from stribeck.report.figures.withheld import (
    BINS,
    confusion_figure,
    limits_figure,
    reliability_figure,
    shrinkage_figure,
    strength_figure,
)
from stribeck.report.numbers import number, percent, percent_interval
from stribeck.report.page import Answer, Facts, Files, Picture, Row, Section, Table, render
from stribeck.report.style import data_uri, finding_of, png_and_svg

Score = Mapping[str, Any]
SHARE_LINES = ("calibration error",)  # among what is asked, plain numbers; all others are shares


class Plot(NamedTuple):
    """A figure of a score: file, function, caption."""

    file: str
    draw: Callable[[Score], Figure | None]
    caption: str


PLOTS = (
    Plot(
        "strength.png",
        strength_figure,
        "Cases with one hidden effect that the library holds, by the torque that the effect is worth over the noise "
        "floor of the recording. A name counts as right when the hidden effect is it, or is listed as equivalent.",
    ),
    Plot(
        "confusion.png",
        confusion_figure,
        "One row for what was hidden, one column for what was said; pairs are left out. Where the effect was left "
        "out of the library, any name is wrong.",
    ),
    Plot(
        "reliability.png",
        reliability_figure,
        "The likeliest answer of each case, in ten bins of its stated probability: on the dashed line probabilities "
        "mean what they say. Bars are 95 % intervals.",
    ),
    Plot(
        "limits.png",
        limits_figure,
        "The strength at which each effect is named half of the time, by logistic regression over its cases, with "
        "95 % intervals by bootstrap.",
    ),
    Plot(
        "shrinkage.png",
        shrinkage_figure,
        "The part of the closable gap that the named effects close: as the diagnosis claims it on its held-out runs, "
        "and on motions of the same arm that were recorded for this score only.",
    ),
)


def write_score_report(score: Score, folder: Path | str) -> None:
    """Write ``report.html`` and the PNG figures into an existing folder.

    Parameters
    ----------
    score : mapping
        The content of ``score.json``; what has nothing to show is left out of the page.
    folder : path
        Made whole by the caller (:func:`stribeck.outputs.whole_folder`).
    """
    folder = Path(folder)
    sections: list[Section | None] = [
        _answer(score), _asked(score), *pictures(PLOTS, score, folder), _effects(score), _outside(score),
        _intervals(score), _failures(score), _method(score),
    ]  # fmt: skip
    made = [section for section in sections if section is not None]
    shown = tuple((s.file, s.title) for s in made if isinstance(s, Picture))
    made.append(Files("Files beside this page", (("score.json", "all of this, and every case, for programs"), *shown)))
    footer = f"stribeck {score['version']}. This page is one file: it loads nothing and runs nothing."
    (folder / "report.html").write_text(render("Withheld check", made, footer), encoding="utf-8")


def pictures(plots: tuple[Plot, ...], score: Score, folder: Path) -> list[Picture]:
    """Draw figures, write them as PNG, and return them as sections of a page."""
    made = []
    for plot in plots:
        figure = plot.draw(score)
        if figure is not None:
            raster, vector = png_and_svg(figure)
            (folder / plot.file).write_bytes(raster)
            made.append(Picture(finding_of(figure), data_uri(vector, "svg+xml"), plot.caption, plot.file))
    return made


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


def _answer(score: Score) -> Answer:
    judged = [line for line in score["targets"] if line["holds"] is not None]
    hold = sum(line["holds"] for line in judged)
    tone = "good" if hold == len(judged) else "partial" if hold else "open"
    single, pairs = score["single"], score["pairs"]["all"]
    sentences = [
        ("Named?", _strengths(single)),
        ("Wrong?", f"{share(single['all']['wrong_name'])} of the answers to single effects give a wrong name."),
        ("Silent?", f"False alarms where nothing is hidden: {share(score['none']['false_alarms'])}. Outside the "
                    f"library no wrong name is given in {share(score['outside']['abstained'])}."),
        ("Where?", f"At strengths of 3 and more the joint is right in {share(single['strong']['joint'])}, "
                   f"the channel in {share(single['strong']['channel'])}."),
        ("Two?", f"Both of a pair: {share(pairs['both'])}, one at least in {share(pairs['at_least_one'])}."),
        ("Sure?", _sure(score)),
    ]  # fmt: skip
    counts = f"{score['cases']} sealed cases, key {score['digest'][:12]}…, code {score['code'][:12]}…"
    return Answer("Withheld check", f"{hold} of {len(judged)} hold", tone, counts, tuple(sentences))


def _strengths(single: Score) -> str:
    parts = [
        f"{share(single[name]['named'])} at strength {text}"
        for name, text in BINS.items()
        if single[name]["named"]["n"]
    ]
    return f"Named: {'; '.join(parts)}." if parts else "No single effects were hidden."


def _sure(score: Score) -> str:
    found = score["calibration"]["likeliest"]
    if found["ece"] is None:
        return "No probabilities were stated."
    held = share(score["intervals"]["coverage"])
    return f"Stated probabilities are off by {number(found['ece'], 2)} on average; 95 % intervals hold in {held}."


def _asked(score: Score) -> Table:
    rows = []
    for line in score["targets"]:
        show = (lambda x: number(x, 2)) if line["what"] in SHARE_LINES else percent
        have = "not tried" if line["have"] is None else show(line["have"])
        asked = f"{'at least' if line['at_least'] else 'at most'} {show(line['want'])}"
        verdict = {True: "holds", False: "does not hold", None: ""}[line["holds"]]
        rows.append(Row((line["what"], asked, have, verdict), "flag" if line["holds"] is False else ""))
    return Table("What is asked, and what holds", ("", "asked", "measured", ""), tuple(rows), frozenset({1, 2}))


def _effects(score: Score) -> Table | None:
    if not score["effects"]:
        return None
    rows = []
    for name, row in score["effects"].items():
        limit = row["detection_limit"]
        mark = {"below": "< ", "above": "> "}.get(limit["outside"] or "", "") if limit else ""
        text = f"{mark}{number(limit['strength'], 2)}" if limit else "–"
        counted = (_counted(row[what]) for what in ("named", "clean", "wrong_name", "joint"))
        rows.append(Row((words.effect(name), *counted, text)))
    columns = ("effect", "named", "and nothing else", "wrong name", "joint right", "limit (strength)")
    note = "Cases, with the 95 % interval of their share (Wilson). The limit is the strength at which half are named."
    return Table("Effect by effect", columns, tuple(rows), frozenset(range(1, 6)), note)


def _outside(score: Score) -> Table | None:
    found = score["outside"]
    if not found["abstained"]["n"]:
        return None
    rows = [Row((words.effect(name), share(row))) for name, row in found["effects"].items()]
    return Table("Effects outside the library", ("hidden", "no wrong name"), tuple(rows), frozenset({1}))


def _intervals(score: Score) -> Table | None:
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


def _failures(score: Score) -> Table | None:
    rows = [
        Row((row["case"], " and ".join(words.effect(e) for e in row["effects"]) or "nothing",
             "–" if row["strength"] is None else number(row["strength"], 2),
             words.listing([words.effect(name) for name in row["extra"]]) or words.short(row["error"] or "", 80)))
        for row in score["rows"] if row["extra"] or row["error"]
    ]  # fmt: skip
    if not rows:
        return None
    return Table("Cases that went wrong", ("case", "hidden", "strength", "wrongly said"), tuple(rows), frozenset({2}))


def _method(score: Score) -> Facts:
    time = score["time"]
    return Facts(
        "How it was done",
        (
            ("Recorded by", "a plant of its own: other equations, other integrator, no code in common"),
            ("Sealed", f"SHA-256 of the salted answers, shown before the diagnosis: {score['digest']}"),
            ("Diagnosed by", _source(score)),
            ("Classes", _classes(score)),
            ("Strength", "torque that the hidden effect is worth along the motions, over what noise and filters "
                         "leave unexplained without it"),
            ("Library", f"{len(score['library'])} effects"),
            ("Time", f"{number(time['median'], 3)} s a case (median), {number(time['longest'], 3)} s at most; "
                     f"{number(time['processor_median'], 3)} s of one processor (median)"),
        ),
    )  # fmt: skip


def _source(score: Score) -> str:
    mixed = f"; the answers come from {score['sources']} different sources" if score["sources"] > 1 else ""
    return f"stribeck {score['version']}, source {score['code'][:16]}…{mixed}"


def _classes(score: Score) -> str:
    size = score["single"]["all"]["class_size"]
    return (
        "no name was given"
        if size is None
        else f"a name stands for {number(size, 2)} effects on average, itself included"
    )
