"""What several commands share: arguments, progress on screen, and the loading of recordings."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from stribeck.arm import Arm
from stribeck.errors import InputError
from stribeck.run import Run, load_run
from stribeck.stopping import stop_if_asked

OutDir = Annotated[Path, typer.Option("--out", metavar="DIR", help="New folder; written whole or not at all.")]


@contextmanager
def progress(task: str) -> Iterator[Callable[[str], None]]:
    """Show on standard error what is being done; line by line where there is no terminal."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield unless_asked(lambda text: print(f"{task}: {text}", file=sys.stderr, flush=True))
        return
    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        number = bar.add_task(task)
        yield unless_asked(lambda text: bar.update(number, description=text))


def unless_asked(show: Callable[[str], None]) -> Callable[[str], None]:
    """Return what shows a text, unless the program has been asked to stop: then it ends."""

    def told(text: str) -> None:
        stop_if_asked()
        show(text)

    return told


def load_runs(arm: Arm, fitted: Sequence[Path], judged: Sequence[Path]) -> tuple[list[Run], list[Run]]:
    """Load the runs of both kinds; one that is given twice would judge a fit by its own data.

    Files of one name go by that of their folders as well.
    """
    paths = [*fitted, *judged]
    true = [os.path.realpath(path) for path in paths]  # not resolve(): it raises where links go round in a circle
    _once(true, paths)
    runs = [replace(load_run(path, arm.n), name=name) for path, name in zip(paths, _names(true), strict=True)]
    _once([run.q.tobytes() + run.tau.tobytes() for run in runs], paths)
    for run in runs:
        for text in run.warnings:
            print(f"warning: {run.name}: {text}", file=sys.stderr)
    return runs[: len(fitted)], runs[len(fitted) :]


def _once(told: Sequence[str | bytes], paths: Sequence[Path]) -> None:
    """Raise `InputError` where two files are told by the same."""
    first: dict[str | bytes, Path] = {}
    for own, path in zip(told, paths, strict=True):
        if own in first:
            raise InputError("a run is given twice", f"{first[own]} and {path}", "give each recording once")
        first[own] = path


def _names(paths: Sequence[str]) -> list[str]:
    """Return the files' names, with as many of their folders as tell them apart."""
    parts = [Path(path).parts for path in paths]
    names = ["/".join(own[-1:]) for own in parts]
    for depth in range(2, max(map(len, parts), default=0) + 1):
        again = {name for name in names if names.count(name) > 1}
        names = ["/".join(own[-depth:]) if name in again else name for own, name in zip(parts, names, strict=True)]
    return names
