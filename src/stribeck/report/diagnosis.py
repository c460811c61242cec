"""The report of a diagnosis: ``report.html`` and its figures."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from matplotlib.figure import Figure

from stribeck.gap.answer.files import NEXT_REFERENCE
from stribeck.gap.result import Diagnosis
from stribeck.report import sentences, tables, words
from stribeck.report.delivered import delivered_table
from stribeck.report.figures.candidates import candidates_figure
from stribeck.report.figures.measured import measured_figure
from stribeck.report.figures.residual import residual_figure
from stribeck.report.figures.waterfall import waterfall_figure
from stribeck.report.figures.where import where_figure
from stribeck.report.page import Answer, Bullets, Files, Picture, Section, footer_of, render
from stribeck.report.recordings import recording_table
from stribeck.report.style import data_uri, finding_of, png_and_svg
from stribeck.report.tuned import tuned_table
from stribeck.version import package_version

TONE = {"no_gap": "good", "explained": "named", "partly_explained": "partial", "unexplained": "open"}


class _Plot(NamedTuple):
    file: str
    draw: Callable[[Diagnosis], Figure | None]
    caption: str
    abstained: str = ""


PLOTS = (
    _Plot(
        "measured_nominal_corrected.png",
        measured_figure,
        "{effort} along the recorded motion, on the stretch of the {held} where the re-tuned model misses most: "
        "measured (the filtered command), the nominal model as given, and the corrected one.",
        "{effort} along the recorded motion, on the stretch of the {held} where the re-tuned model misses most: "
        "measured (the filtered command), the nominal model as given, and re-tuned.",
    ),
    _Plot(
        "waterfall.png",
        waterfall_figure,
        "Each bar is what is left at that stage, the hatching what the stage took away, the dotted line the noise "
        "floor. No simulated motion reaches the encoder's noise: what the drive's noise does to it adds up.",
    ),
    _Plot(
        "where.png",
        where_figure,
        "How what re-tuning leaves of each joint's squared residual beyond noise spreads over the regions of its "
        "motion, a family of them at a time; what the joint is stuck for has no direction. Of frequencies, noise is "
        "not taken off.",
    ),
    _Plot(
        "residual.png",
        residual_figure,
        "{effort} that the model does not account for, before and after the named effects; "
        "shaded, the stretch of the first figure.",
        "{effort} that the re-tuned model does not account for; shaded, the stretch of the first figure.",
    ),
    _Plot(
        "candidates.png",
        candidates_figure,
        "What each candidate gains on {unfitted}. What is added, all samples together decide, and how far it spares "
        "the nominal values; held-out ones that hardly excite an effect need not confirm it.",
    ),
)


def write_report(diagnosis: Diagnosis, folder: Path | str) -> None:
    """Write ``report.html`` and the PNG figures into an existing folder.

    Parameters
    ----------
    diagnosis : Diagnosis
        What has nothing to show (no trace, no candidate, no region) is left out of the page.
    folder : path
        Made whole by the caller (:func:`stribeck.outputs.whole_folder`).
    """
    folder = Path(folder)
    pictures = []
    for plot in PLOTS:
        figure = plot.draw(diagnosis)
        if figure is not None:
            raster, vector = png_and_svg(figure)
            (folder / plot.file).write_bytes(raster)
            caption = plot.caption if diagnosis.named or not plot.abstained else plot.abstained
            caption = caption.format(
                effort=words.effort(diagnosis).capitalize(),
                held=words.held(diagnosis),
                unfitted=words.unfitted(diagnosis),
            )
            pictures.append(Picture(finding_of(figure), data_uri(vector, "svg+xml"), caption, plot.file))
    page = render(
        f"{words.clean(diagnosis.arm)}: diagnosis", page_sections(diagnosis, pictures), footer_of(package_version())
    )
    (folder / "report.html").write_bytes(page.encode("utf-8", "replace"))


def page_sections(diagnosis: Diagnosis, pictures: list[Picture]) -> list[Section]:
    """Return the sections of the page in reading order."""
    warnings = tuple(words.clean(text) for text in diagnosis.warnings)
    sections: list[Section | None] = [
        _answer(diagnosis),
        Bullets("Mind this", warnings, "warning") if warnings else None,
        *pictures,
        tables.stage_table(diagnosis),
        recording_table(diagnosis),
        tables.cause_table(diagnosis),
        tables.parameter_table(diagnosis),
        tables.laws(diagnosis),
        tables.next_experiment(diagnosis),
        delivered_table(diagnosis),
        tuned_table(diagnosis) if diagnosis.tuned else None,
        tables.search_path(diagnosis),
        tables.method(diagnosis, package_version()),
        _files(pictures, diagnosis),
    ]
    return [section for section in sections if section is not None]


def _answer(diagnosis: Diagnosis) -> Answer:
    fitted, held = len(diagnosis.fit_runs), len(diagnosis.held_out_runs)
    judged = f"judged on {held} held-out run{'s' * (held != 1)}"
    fit = f"fitted to {fitted} run{'s' * (fitted != 1)}, {judged}"
    if words.of_one(diagnosis):
        fit = "fitted to the first part of a run, judged on the last part of it"
    subtitle = f"Sim-to-real gap of {words.joints(diagnosis.joints)}: {fit}."
    badge = words.VERDICT.get(diagnosis.verdict, diagnosis.verdict)
    tone = TONE.get(diagnosis.verdict, "open")
    return Answer(words.clean(diagnosis.arm), badge, tone, subtitle, sentences.answers(diagnosis))


def _files(pictures: list[Picture], diagnosis: Diagnosis) -> Files:
    further = [(NEXT_REFERENCE, "what a controller is to follow next")] if diagnosis.next_reference else []
    files = [
        ("diagnosis.json", "all of the above for programs"),
        ("corrected.toml", "the re-tuned arm with the named effects, an arm file for the other commands"),
        *further,
        *((picture.file, picture.title) for picture in pictures),
    ]
    return Files("Files beside this page", tuple(files))
