"""The report of a limit-cycle analysis: ``report.html``, its figures, and the table for the terminal."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from matplotlib.figure import Figure
from rich.console import Group, RenderableType
from rich.table import Table as Screen
from rich.text import Text

from stribeck.loop.answers import Analysis, JointAnswer
from stribeck.report import words
from stribeck.report.cycle_tables import gain_facts, method_facts, method_table, verdict_table
from stribeck.report.cycle_words import VERDICT, answer_sentences, headline, reads_as
from stribeck.report.figures.cycle_branch import branch_figure
from stribeck.report.figures.cycle_map import map_figure
from stribeck.report.figures.cycle_trace import trace_figure
from stribeck.report.figures.nyquist import nyquist_figure
from stribeck.report.figures.portrait import portrait_figure
from stribeck.report.figures.root_locus import locus_figure
from stribeck.report.page import Answer, Bullets, Files, Picture, Section, footer_of, render
from stribeck.report.style import data_uri, finding_of, png_and_svg
from stribeck.version import package_version

TONE = {"rest": "good", "steady": "good", "unbounded": "open", "undetermined": "open"}


class _Plot(NamedTuple):
    file: str
    draw: Callable[[Analysis, int], Figure | None]
    caption: str


PLOTS = (
    _Plot(
        "phase",
        portrait_figure,
        "Velocity over position less reference. Grey: simulated from the loop's own start. Blue: one period of what it "
        "ends in. A joint that sticks stays on the axis.",
    ),
    _Plot(
        "trace",
        trace_figure,
        "Error (reference less position), velocity and commanded torque as simulated from the loop's own start; the "
        "joint sticks where it is shaded. Over the loop file's duration, or four periods where those are longer.",
    ),
    _Plot(
        "branch",
        lambda analysis, i: branch_figure(analysis.joints[i]),
        "Amplitude of the exact cycle, followed downwards; hollow where it is unstable, ∞ where the motion grows "
        "without bound, ? where it is not known; dashed, what the describing function predicts.",
    ),
    _Plot(
        "map",
        lambda analysis, i: map_figure(analysis.joints[i]),
        "What the loop ends in from its own, a small and a large start, cell by cell; cycles are coloured by their "
        "amplitude.",
    ),
    _Plot(
        "nyquist",
        lambda analysis, i: nyquist_figure(analysis.joints[i]),
        "W is the velocity per torque of everything but friction. Where it meets -1/N a sinusoid sustains itself, as "
        "far as one harmonic can tell.",
    ),
    _Plot(
        "poles",
        lambda analysis, i: locus_figure(analysis.joints[i]),
        "Poles of the linear loop, friction left out, as Kp grows; Kv follows Kp where the loop file asks for critical "
        "damping. A sampled loop's are shown as ln(z)/Ts; much faster ones lie outside, up to those that cross first.",
    ),
)


def write_report(analysis: Analysis, folder: Path | str) -> None:
    """Write ``report.html`` and the figures, ``<figure>_<joint number>.png``, into an existing folder."""
    folder = Path(folder)
    pictures: list[list[Picture]] = []
    for i, _ in enumerate(analysis.joints):
        mine = []
        for plot in PLOTS:
            figure = plot.draw(analysis, i)
            if figure is not None:
                mine.append(_picture(figure, f"{plot.file}_{analysis.indices[i] + 1}.png", plot.caption, folder))
        pictures.append(mine)
    page = render(
        f"{words.clean(analysis.arm)}: limit cycles", _sections(analysis, pictures), footer_of(package_version())
    )
    (folder / "report.html").write_bytes(page.encode("utf-8", "replace"))


def _picture(figure: Figure, file: str, caption: str, folder: Path) -> Picture:
    raster, vector = png_and_svg(figure)
    (folder / file).write_bytes(raster)
    return Picture(finding_of(figure), data_uri(vector, "svg+xml"), caption, file)


def _sections(analysis: Analysis, pictures: list[list[Picture]]) -> list[Section]:
    notes = tuple(
        f"{words.clean(answer.joint)}: {words.clean(note)}." for answer in analysis.joints for note in answer.notes
    )
    sections: list[Section] = [_answer(analysis)]
    if notes:
        sections.append(Bullets("Mind this", notes, "warning"))
    sections.append(verdict_table(analysis))
    for answer, mine in zip(analysis.joints, pictures, strict=True):
        sections += [method_table(answer), gain_facts(answer), *mine]
    return [*sections, method_facts(analysis.sample_time), _files(pictures)]


def _answer(analysis: Analysis) -> Answer:
    verdicts = [reads_as(answer) for answer in analysis.joints]
    worst = max(verdicts, key=_RANK.index)
    count = len(analysis.joints)
    kind = f"sampled every {1e3 * analysis.sample_time:g} ms" if analysis.sample_time > 0.0 else "continuous"
    subtitle = f"Limit cycles of {count} controlled joint{'s' * (count != 1)}, controller {kind}."
    rows = tuple(row for answer in analysis.joints for row in answer_sentences(answer, count > 1))
    return Answer(words.clean(analysis.arm), VERDICT[worst], TONE.get(worst, "partial"), subtitle, rows)


_RANK = [
    "rest",
    "steady",
    "ripple",
    "forced",
    "sliding_cycle",
    "hunting",
    "stick_slip",
    "chatter",
    "undetermined",
    "unbounded",
]


def _files(pictures: list[list[Picture]]) -> Files:
    figures = ((picture.file, picture.title) for mine in pictures for picture in mine)
    return Files("Files beside this page", (("limit_cycle.json", "all of the above for programs"), *figures))


def summary(analysis: Analysis) -> RenderableType:
    """Return each joint's verdict and the methods side by side, for rich to print."""
    parts: list[RenderableType] = []
    for answer in analysis.joints:
        doubt = f"describing function: {words.clean(answer.methods['describing_function'].why)}"
        parts += [Text(headline(answer), "bold"), _screen(answer), Text(doubt, "dim")]
        parts += [Text(f"warning: {words.clean(note)}", "yellow") for note in answer.notes]
    return Group(*parts)


def _screen(answer: JointAnswer) -> Screen:
    table = Screen(box=None, padding=(0, 1, 0, 0))
    source = method_table(answer)
    for k, name in enumerate(source.columns[:-1]):
        table.add_column(name.replace(", ", ",\n"), justify="right" if k in source.numeric else "left", no_wrap=True)
    for row in source.rows:
        table.add_row(*(Text(cell) for cell in row.cells[:-1]))
    return table
