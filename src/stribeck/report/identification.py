"""The report of an identification: ``report.html``, its figure, and the table for the terminal."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from rich.table import Table as Screen
from rich.text import Text

from stribeck.arm import unit_at
from stribeck.gap.result import Estimate
from stribeck.identify.files import UNITS
from stribeck.identify.findings import Direction, Identification
from stribeck.identify.tustin_fit import NAMES
from stribeck.report import words
from stribeck.report.figures.friction_curve import READINGS, SOURCE, friction_curve_figure
from stribeck.report.numbers import estimate, interval, number, percent, unit_text
from stribeck.report.page import Answer, Bullets, Facts, Files, Picture, Row, Section, Table, footer_of, render
from stribeck.report.style import data_uri, finding_of, png_and_svg
from stribeck.version import package_version

FIGURE = "friction_curve.png"
CAPTION = {
    READINGS: "Points: one trial each.",
    "Section 3": "Dashed: the paper's Section 3, by hand.",
    "IPOPT, readings": "Solid: IPOPT on the same readings, with the 95 % band of the curve.",
    "IPOPT, whole runs": "Dotted: IPOPT on the whole recordings, which uses no readings.",
    SOURCE["other direction"]: "Grey, dash-dotted: the other direction's constants, which are taken.",
    SOURCE["nominal"]: "Grey: the arm file's constants, which are taken.",
}


def write_report(found: Identification, folder: Path | str) -> None:
    """Write ``report.html`` and ``friction_curve.png`` into an existing folder."""
    folder, pictures = Path(folder), []
    figure = friction_curve_figure(found)
    if figure is not None:
        raster, vector = png_and_svg(figure)
        (folder / FIGURE).write_bytes(raster)
        drawn = {str(line.get_label()) for ax in figure.axes for line in ax.get_lines()}
        caption = " ".join(text for label, text in CAPTION.items() if label in drawn)
        pictures.append(Picture(finding_of(figure), data_uri(vector, "svg+xml"), caption, FIGURE))
    page = render(
        f"{words.clean(found.nominal.name)}: identification", _sections(found, pictures), footer_of(package_version())
    )
    (folder / "report.html").write_bytes(page.encode("utf-8", "replace"))


def summary(found: Identification) -> Screen:
    """Return the constants that ``fitted.toml`` takes, for rich to print."""
    table = Screen(box=None, padding=(0, 2, 0, 0))
    for name in ("joint", "direction", *NAMES, "taken"):
        table.add_column(name, justify="left" if name in ("joint", "direction", "taken") else "right")
    for joint, own in zip(found.joints, found.arm.joints, strict=True):
        sides = {"forward": own.friction, "backward": own.backward}
        for way, one in joint.directions.items():
            values = [number(getattr(sides[way], name)) for name in NAMES]
            table.add_row(*(Text(text) for text in (words.short(joint.name), way, *values, SOURCE[one.source])))
    return table


def _sections(found: Identification, pictures: list[Picture]) -> list[Section]:
    warnings = tuple(words.clean(text) for text in found.warnings)
    sections: list[Section | None] = [
        _answer(found),
        Bullets("Mind this", warnings, "warning") if warnings else None,
        *pictures,
        _constants(found),
        _by_hand(found),
        _remarks(found),
        _method(found),
        _files(pictures),
    ]
    return [section for section in sections if section is not None]


def _answer(found: Identification) -> Answer:
    sources = [one.source for joint in found.joints for one in joint.directions.values()]
    good = bool(sources) and all(source == "curve" for source in sources)
    some = any(source in ("curve", "runs") for source in sources)
    badge = "Identified" if good else "Partly identified" if some else "Not identified"
    count = len(found.runs)
    subtitle = f"Tustin friction of {words.joints(found.nominal.names)} from {count} recording{'s' * (count != 1)}."
    answers = tuple((words.clean(joint.name), _sentence(found, k)) for k, joint in enumerate(found.joints))
    tone = "named" if good else "partial" if some else "open"
    return Answer(words.clean(found.nominal.name), badge, tone, subtitle, answers)


def _sentence(found: Identification, k: int) -> str:
    joint, own = found.joints[k], found.arm.joints[k]
    if not joint.directions:
        return "It did not move; its friction stays as the arm file has it."
    unit = unit_text(unit_at(UNITS["C0"], own.kind))
    way, one = next(iter(joint.directions.items()))
    friction = own.friction if way == "forward" else own.backward
    level = f"Break-away {number(friction.C0 + friction.C1)} {unit}, Coulomb {number(friction.C0)} {unit}"
    said = f"{level} ({SOURCE[one.source]}; {way})."
    if joint.asymmetry is None:
        return said
    chance = f"equal directions would differ so with probability {percent(joint.asymmetry)}"
    return f"{said} The directions {'differ' if joint.asymmetric else 'do not clearly differ'}: {chance}."


def _constants(found: Identification) -> Table | None:
    rows = []
    for joint, nominal in zip(found.joints, found.nominal.joints, strict=True):
        for way, one in joint.directions.items():
            for i, name in enumerate(NAMES):
                rows.append(_constant_row((words.clean(joint.name), way), one, i, unit_at(UNITS[name], nominal.kind)))
    columns = ("joint", "direction", "", "Section 3", "IPOPT, readings", "95 % interval", "IPOPT, runs",
               "95 % interval", "unit")  # fmt: skip
    note = (
        "In grey: left open, by readings where they do not bound it on both sides, by runs (where there is no curve "
        "through readings) where half its tolerance or more is left. A dash: the step could not be made."
    )
    return Table("The constants, three ways", columns, tuple(rows), frozenset({3, 4, 5, 6, 7}), note) if rows else None


def _constant_row(head: tuple[str, str], one: Direction, i: int, unit: str) -> Row:
    by_hand = one.section3.constants[i] if one.section3 is not None else np.nan
    curve = Estimate(float(one.curve.constants[i]), float(one.curve.low[i]), float(one.curve.high[i]))
    whole = Estimate(float(one.runs[0, i]), float(one.runs[1, i]), float(one.runs[2, i]))
    cells = [number(float(by_hand)) if np.isfinite(by_hand) else "–"]
    cells += [estimate(curve), interval(curve)] if one.curve.ok else ["–", "–"]
    cells += [estimate(whole), interval(whole)]
    sure = one.curve.identified[i] if one.curve.ok else one.runs_identified[i]
    return Row((*head, NAMES[i], *cells, unit_text(unit)), "" if sure else "muted")


def _by_hand(found: Identification) -> Table | None:
    rows = []
    for joint in found.joints:
        for way, one in joint.directions.items():
            steps = one.section3
            if steps is None:
                continue
            line, saddle = steps.line, steps.saddle
            cells = (
                words.clean(joint.name),
                way,
                "–" if line is None else f"{number(line.second)} and {number(line.first)}",
                "–" if steps.break_away is None else number(steps.break_away),
                "–" if saddle is None else f"{number(saddle.torque)} at {number(saddle.velocity)}",
                number(steps.condition) if np.isfinite(steps.condition) else "–",
                " or ".join(number(value) for value in steps.alphas_by_velocity) or "none",
            )
            rows.append(Row(cells, "" if steps.ok else "flag"))
    kind = found.nominal.joints[0].kind
    torque, speed = (unit_text(unit_at(UNITS[name], kind)) for name in ("C0", "alpha"))
    columns = ("joint", "direction", f"3.1: velocities, {speed}", f"3.2: break-away, {torque}",
               f"3.3: saddle, {torque} at {speed}", "condition (2)",
               f"alpha by (3) instead of (12), {speed}")  # fmt: skip
    note = "Condition (2), C2 alpha / C1 < 1, must hold for a bend. Highlighted: the procedure gave no Tustin curve."
    return Table("Section 3, step by step", columns, tuple(rows), frozenset({3}), note) if rows else None


def _remarks(found: Identification) -> Bullets | None:
    items = tuple(
        f"{words.clean(joint.name)}, {way}: {text}"
        for joint in found.joints
        for way, one in joint.directions.items()
        if one.section3 is not None
        for text in one.section3.remarks
    )
    return Bullets("What to mind in Section 3's steps", items) if items else None


def _method(found: Identification) -> Facts:
    least = (
        "Tustin's model is linear in C0, C1 and C2 for any one alpha: least squares in three constants and a search in "
        "the fourth start IPOPT, whose solution is the least-squares fit that the paper took for impossible."
    )
    pairs = (
        ("least squares", least),
        ("readings", "steady sliding of half a second or more, and break-away under a torque that rises slowly; what "
                     "gravity, the other joints and acceleration need is taken off"),
        ("intervals", "readings: profile of the sum of squares, trials independent; whole runs: blocks of one "
                      "second, or of one run each where there are a dozen or more"),
        ("fit to whole runs", found.whole.fit.status.replace("_", " ").lower()),
        *(("note", words.clean(note)) for note in found.notes),
        ("stribeck", package_version()),
    )  # fmt: skip
    return Facts("How it was done", pairs)


def _files(pictures: list[Picture]) -> Files:
    files = [
        ("identification.json", "all of the above for programs"),
        ("fitted.toml", "the arm with the fitted friction, for simulate, predict, limit-cycle and export-fmu"),
        *((picture.file, picture.title) for picture in pictures),
    ]
    return Files("Files beside this page", tuple(files))
