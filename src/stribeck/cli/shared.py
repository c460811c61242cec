"""What several commands share: arguments, progress on screen, and the loading of recordings."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from stribeck.arm import Arm, doubtful_values, load_arm
from stribeck.errors import WARNING
from stribeck.run import Run, check_apart, load_runs
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

        def show(text: str) -> None:
            if text.startswith(WARNING):
                console.print(text, highlight=False, markup=False, soft_wrap=True)
            else:
                bar.update(number, description=text)

        yield unless_asked(show)


def unless_asked(show: Callable[[str], None]) -> Callable[[str], None]:
    """Return what shows a text, unless the program has been asked to stop: then it ends."""

    def told(text: str) -> None:
        stop_if_asked()
        show(text)

    return told


def load_model(path: Path) -> Arm:
    """Load an arm file whose effects are known, too: that is found now, and told with the file's name.

    What to doubt of its values is said at once.
    """
    from stribeck.effects.placing import placed_effects

    arm = load_arm(path)
    placed_effects(arm, str(path))
    warn(doubtful_values(arm))
    return arm


def check_library() -> None:
    """Load all effects now: one of another package that is declared wrongly is told before any work is done."""
    from stribeck.effects.registry import laws

    laws()


def read_runs(arm: Arm, fitted: Sequence[Path], judged: Sequence[Path] = ()) -> tuple[list[Run], list[Run]]:
    """Load the runs of both kinds and say what to doubt of them, before any work is done."""
    runs = load_runs((*fitted, *judged), arm.n, arm.kinds)
    check_apart(runs)
    warn(doubts(runs))
    return runs[: len(fitted)], runs[len(fitted) :]


def doubts(runs: Sequence[Run]) -> list[str]:
    """Return what reading runs gave reason to doubt, as their analysis says it again among its own warnings."""
    return [f"{run.name}: {text}" for run in runs for text in run.warnings]


def warn(texts: Sequence[str]) -> None:
    """Show warnings on standard error, a line each."""
    for text in texts:
        print(f"{WARNING}{text}", file=sys.stderr)


def tell(notes: Sequence[str]) -> None:
    """Show notes on what was done, a line each."""
    for text in notes:
        print(f"note: {text}")
