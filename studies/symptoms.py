"""Question: what does each effect look like in the torque left unexplained? Draws them all.

Method: the independent plant records one joint that swings under gravity, as it is and with each effect of the library
hidden in it in turn, clear in strength, under encoder noise. Its data sheet, nearly right, is re-tuned to the
recordings; the residual is drawn across the signal that the effect's class names in ``shows``, and over it what the
family's law takes, once fitted. No effect is drawn in a way of its own.
Expected: each as its class says under ``symptom``; several times the residual without the effect, most of it the law's.
"""

from __future__ import annotations

from pathlib import Path

import typer
from _output import OUT, write
from _symptom_cases import case_of
from _symptom_figure import contact_sheet, small_png, symptom_figure
from _symptom_signals import sizes, symptom_of
from rich import print as show

from stribeck.effects.registry import registry
from stribeck.report.symptom import picture_file
from stribeck.withheld.injections import KNOWN

SHEET = Path(__file__).with_name("symptoms.png")


def main(only: str = "", ship: bool = False) -> None:
    """Draw all effects, or those named with commas; ``--ship`` writes the pictures beside the effects' own files."""
    result, pictures = {}, {}
    for effect in registry().values():
        if effect.name not in (only.split(",") if only else KNOWN):  # what the plant does not know cannot be drawn
            continue
        case = case_of(effect)
        symptom = symptom_of(effect, case)
        pictures[effect.name] = small_png(symptom_figure(effect, symptom))
        result[effect.name] = {"shows": effect.shows, "symptom": effect.symptom, "rms": sizes(case, symptom)}
        show(effect.name, result[effect.name]["rms"])
        if ship:
            picture_file(effect).write_bytes(pictures[effect.name])
    write("symptoms", result)
    for name, picture in pictures.items():
        (OUT / "symptoms" / f"{name}.png").write_bytes(picture)
    sheet = contact_sheet(list(pictures.values()))
    (OUT / "symptoms" / "all.png").write_bytes(sheet)
    if ship and not only:
        SHEET.write_bytes(sheet)


if __name__ == "__main__":
    typer.run(main)
