"""What several commands share: arguments, progress on screen, and the loading of recordings."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from stribeck.arm import Arm, load_arm
from stribeck.errors import InputError
from stribeck.run import Run, load_run

OutDir = Annotated[Path, typer.Option("--out", metavar="DIR", help="New folder; written whole or not at all.")]


@contextmanager
def progress(task: str) -> Iterator[Callable[[str], None]]:
    """Show on standard error what is being done; line by line where there is no terminal."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda text: print(f"{task}: {text}", file=sys.stderr, flush=True)
        return
    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        number = bar.add_task(task)
        yield lambda text: bar.update(number, description=text)


def load_model(path: Path) -> Arm:
    """Load an arm file whose effects are known, too: that is found now, and told with the file's name."""
    from stribeck.effects.registry import placed_effects

    arm = load_arm(path)
    placed_effects(arm, str(path))
    return arm


def load_runs(arm: Arm, fitted: Sequence[Path], judged: Sequence[Path]) -> tuple[list[Run], list[Run]]:
    """Load the runs of both kinds and say what to doubt of them, before any work is done.

    A file that is given twice would judge a fit by its own data.
    """
    seen: set[str] = set()
    for path in (*fitted, *judged):
        true = os.path.realpath(path)  # not resolve(): it raises where links go round in a circle
        if true in seen:
            raise InputError("a run is given twice", str(path), "give each recording once")
        seen.add(true)
    runs = [load_run(path, arm.n) for path in (*fitted, *judged)]
    warn(doubts(runs))
    return runs[: len(fitted)], runs[len(fitted) :]


def doubts(runs: Sequence[Run]) -> list[str]:
    """Return what reading runs gave reason to doubt, as their analysis says it again among its own warnings."""
    return [f"{run.name}: {text}" for run in runs for text in run.warnings]


def warn(texts: Sequence[str]) -> None:
    """Show warnings on standard error, a line each."""
    for text in texts:
        print(f"warning: {text}", file=sys.stderr)
