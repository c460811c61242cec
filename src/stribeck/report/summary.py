"""The answer for the terminal."""

from __future__ import annotations

import math
from collections.abc import Collection

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from stribeck.gap.result import Diagnosis
from stribeck.report import sentences, words
from stribeck.report.numbers import number

STYLE = {"no_gap": "bold green", "explained": "bold cyan", "partly_explained": "bold yellow", "unexplained": "bold red"}


def summary(diagnosis: Diagnosis, said: Collection[str] = ()) -> RenderableType:
    """Return the verdict, the sentences, the torque gap per stage, notes and warnings, for rich to print.

    Names go in as plain text: markup and control characters in them do nothing.

    Parameters
    ----------
    diagnosis : Diagnosis
    said : collection of str
        Warnings that the screen shows already.
    """
    head = Text(words.VERDICT.get(diagnosis.verdict, diagnosis.verdict), STYLE.get(diagnosis.verdict, "bold"))
    head.append(f"  {words.clean(diagnosis.arm)}", "default not bold")
    parts: list[RenderableType] = [head, _answers(diagnosis)]
    if diagnosis.stages:
        parts.append(_stages(diagnosis))
    parts += [Text(f"note: {words.clean(text)}", "dim") for text in diagnosis.notes]
    parts += [Text(f"warning: {words.clean(text)}", "yellow") for text in diagnosis.warnings if text not in said]
    return Group(*parts)


def _answers(diagnosis: Diagnosis) -> Table:
    table = Table.grid(padding=(0, 2))
    table.add_column(style="dim", no_wrap=True)
    table.add_column(overflow="fold")
    for question, sentence in sentences.answers(diagnosis):
        table.add_row(Text(question), Text(sentence))
    return table


def _stages(diagnosis: Diagnosis) -> Table:
    table = Table(box=None, padding=(0, 2, 0, 0), title_justify="left")
    table.add_column(Text(f"{words.effort(diagnosis)} rms, {words.torque_unit(diagnosis)}, held-out"), style="dim")
    for joint in diagnosis.joints:
        table.add_column(Text(words.short(joint)), justify="right")
    for stage in diagnosis.stages:
        values = (stage.torque.get(joint, math.nan) for joint in diagnosis.joints)
        table.add_row(Text(words.stage(stage.stage)), *(Text(number(value)) for value in values))
    return table
