"""The report of a withheld check: ``report.html`` and its figures, from the content of ``score.json``."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from matplotlib.figure import Figure

from stribeck.report.figures.confusion import confusion_figure
from stribeck.report.figures.withheld import (
    BINS,
    limits_figure,
    reliability_figure,
    shrinkage_figure,
    strength_figure,
    strength_left_figure,
)
from stribeck.report.numbers import number
from stribeck.report.page import Answer, Facts, Files, Picture, Section, footer_of, render
from stribeck.report.style import data_uri, finding_of, png_and_svg
from stribeck.report.withheld_tables import (
    asked,
    by_strength,
    effect_by_effect,
    failures,
    intervals,
    outside,
    pairs,
    several,
    share,
)

Score = Mapping[str, Any]


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
        "floor of the recording. A name counts as right when the hidden effect is it, or is listed as equivalent; an "
        "answer that gives a wrong name beside it counts twice.",
    ),
    Plot(
        "strength_left.png",
        strength_left_figure,
        "The same cases by what is left of that torque once the nominal values are re-tuned within their stated "
        "tolerances: what re-tuning takes up (a payload within the tolerance of a mass, a small drive gain) is a wrong "
        "value, and nothing is there to be named.",
    ),
    Plot(
        "confusion.png",
        confusion_figure,
        "One row for what was hidden, one column for what was said; pairs are left out. Heavier lines part the stages "
        "of the signal path, and what no library holds. Where the effect was left out of the library, any name is "
        "wrong.",
    ),
    Plot(
        "reliability.png",
        reliability_figure,
        "The likeliest answer of each case, in ten bins of its stated probability: on the dashed line probabilities "
        "mean what they say. Bars are 95 % intervals, numbers the answers in each bin.",
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
        "and on motions of the same arm that were recorded for this score only. A corrected model at the noise floor "
        "closes all of it.",
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
        _answer(score), asked(score), *by_strength(score), *pictures(PLOTS, score, folder), effect_by_effect(score),
        pairs(score), several(score), outside(score), intervals(score), failures(score), _method(score),
    ]  # fmt: skip
    made = [section for section in sections if section is not None]
    shown = tuple((s.file, s.title) for s in made if isinstance(s, Picture))
    made.append(Files("Files beside this page", (("score.json", "all of this, and every case, for programs"), *shown)))
    page = render("Withheld check", made, footer_of(score["version"]))
    (folder / "report.html").write_text(page, encoding="utf-8")


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


def _answer(score: Score) -> Answer:
    judged = [line for line in score["targets"] if line["holds"] is not None]
    hold = sum(line["holds"] for line in judged)
    tone = "good" if hold == len(judged) else "partial" if hold else "open"
    single, two, left = score["single"], score["pairs"]["all"], score.get("single_left")
    sentences = [
        ("Named?", _strengths(single, "Named")),
        *([("Re-tuned?", _strengths(left, "By the strength that re-tuning within tolerance leaves"))] if left else []),
        ("Wrong?", f"{share(single['all']['wrong_name'])} of the answers to single effects give a wrong name."),
        ("Silent?", f"False alarms where nothing is hidden: {share(score['none']['false_alarms'])}. Outside the "
                    f"library no wrong name is given in {share(score['outside']['abstained'])}."),
        ("Where?", f"At strengths of 3 and more the joint is right in {share(single['strong']['joint'])}, "
                   f"the channel in {share(single['strong']['channel'])}."),
        ("Two?", f"Both of a pair: {share(two['both'])}, one at least in {share(two['at_least_one'])}."),
        ("Sure?", _sure(score)),
    ]  # fmt: skip
    counts = f"{score['cases']} sealed cases, key {score['digest'][:12]}…, code {score['code'][:12]}…"
    return Answer("Withheld check", f"{hold} of {len(judged)} hold", tone, counts, tuple(sentences))


def _strengths(single: Score, by: str) -> str:
    parts = [
        f"{share(single[name]['named'])} at strength {text}"
        for name, text in BINS.items()
        if single[name]["named"]["n"]
    ]
    return f"{by}: {'; '.join(parts)}." if parts else "No single effects were hidden."


def _sure(score: Score) -> str:
    found = score["calibration"]["likeliest"]
    if found["ece"] is None:
        return "No probabilities were stated."
    held = share(score["intervals"]["coverage"])
    return f"Stated probabilities are off by {number(found['ece'], 2)} on average; 95 % intervals hold in {held}."


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
                         "leave unexplained without it, below 4, 8 or 15 Hz, where it is most: what shows above only "
                         "has none, and may be named all the same; left of it: after the nominal values are re-tuned "
                         "within their tolerances"),
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
