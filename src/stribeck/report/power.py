"""The report of a power analysis: what the user's experiment would have revealed."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from stribeck.report import words
from stribeck.report.figures.power import clearest, power_figure
from stribeck.report.numbers import number, with_unit
from stribeck.report.page import Answer, Files, Row, Section, Table, footer_of, render
from stribeck.report.withheld import PLOTS, Plot, pictures
from stribeck.report.withheld_tables import share

Power = Mapping[str, Any]
FIGURE = Plot(
    "power.png",
    power_figure,
    "One mark a case: an effect hidden in this arm, the experiment recorded anew by an independent plant, and "
    "diagnosed without a hint. To the right, effects that stand out more from the noise.",
)
SHOWN = ("strength.png", "confusion.png", "limits.png")  # of the score's figures


def write_power_report(power: Power, score: Mapping[str, Any], folder: Path | str) -> None:
    """Write ``report.html`` and the PNG figures into an existing folder.

    Parameters
    ----------
    power, score : mapping
        The contents of ``power.json`` and ``score.json``.
    folder : path
        Made whole by the caller (:func:`stribeck.outputs.whole_folder`).
    """
    folder = Path(folder)
    both = {**score, "power": power}
    plots = (FIGURE, *(plot for plot in PLOTS if plot.file in SHOWN))
    figures = pictures(plots, both, folder)
    files = [("power.json", "what would be revealed, for programs"), ("score.json", "every case")]
    files += [(picture.file, picture.title) for picture in figures]
    sections: list[Section] = [
        _answer(power), *figures, _table(power), Files("Files beside this page", tuple(files)),
    ]  # fmt: skip
    title = f"{words.clean(power['arm'])}: what this experiment reveals"
    page = render(title, sections, footer_of(power["version"]))
    (folder / "report.html").write_bytes(page.encode("utf-8", "replace"))


def _answer(power: Power) -> Answer:
    effects = power["effects"]
    seen = [name for name, row in effects.items() if row["revealed_from"]]
    weak = [name for name, row in effects.items() if row["revealed_from"] == "weak"]
    blind = [words.effect(name) for name in effects if name not in seen]
    missing = [words.effect(name) for name in power["not_recorded"]]
    level = clearest(power)
    even = f", {len(weak)} even where weak" if level != "weak" else ""
    sentences = [
        ("Revealed?", f"{len(seen)} of {len(effects)} effects where they are {level}{even}."),
        ("Blind to?", words.listing(blind) or "none of the effects that were tried"),
        *([("Not tried?", f"{words.listing(missing)}: could not be recorded.")] if missing else []),
        ("Trust?", f"False alarms: {share(power['false_alarms'])}. Wrong names: {share(power['wrong_names'])}."),
    ]
    tone = "good" if not blind else "partial" if seen else "open"
    runs = len(power["runs"])
    subtitle = f"{power['cases']} cases on the motions of {runs} run{'s' * (runs != 1)}, by an independent plant."
    return Answer(
        words.clean(power["arm"]), f"{len(seen)} of {len(effects)} revealed", tone, subtitle, tuple(sentences)
    )


def _table(power: Power) -> Table:
    rows = []
    for name, row in sorted(power["effects"].items(), key=lambda item: (_rank(item[1]), item[0])):
        counts = [_count(level) for level in row["levels"].values()]
        mark = "" if row["revealed_from"] else "flag"
        cells = (words.effect(name), *counts, _example(row["found"]), _example(row["missed"]))
        rows.append(Row(cells, mark))
    levels = next(iter(power["effects"].values()))["levels"] if power["effects"] else {}
    columns = (
        "effect",
        *(f"{level}: named" for level in levels),
        "weakest that was named",
        "strongest that was missed",
    )
    note = (
        "Sized to be worth 10 to 25 % of the torque that moves the joint where clear, 5 to 10 % where medium, 1.5 to "
        "5 % where weak, within what can be built; what is clear is made stronger until re-tuning leaves three noise "
        "floors of it. Effects that live at rest or in few milliradians have sizes as they are met in practice, half "
        "the way of an axis that slides standing for a radian. In brackets: the strength (torque over noise floor "
        "below 4, 8 or 15 Hz, where it is most), and what it was worth. Flagged: not even revealed where clear."
    )
    return Table("Effect by effect", columns, tuple(rows), frozenset(range(1, 1 + len(levels))), note)


def _rank(row: Power) -> int:
    return {"weak": 0, "medium": 1, "clear": 2}.get(row["revealed_from"] or "", 3)


def _count(level: Power) -> str:
    if not level["named"]["n"]:
        return "–"
    return f"{level['named']['k']} of {level['named']['n']} ({_size(level)})"


def _example(case: Power | None) -> str:
    if case is None:
        return "–"
    values = [f"{words.clean(n)} {with_unit(p['value'], p['unit'])}" for n, p in case["parameters"].items()]
    place = f"joint {words.short(case['joint'])}"
    return f"{', '.join([*values, place])} ({_size(case)})"


def _size(shown: Power) -> str:
    return f"{number(shown['strength'], 2)}; {number(100.0 * shown['worth'], 2)}\u00a0%"
