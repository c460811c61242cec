"""The program ``stribeck``: one thin function a command. What fails, and how, stands in `stribeck.exits`."""

from __future__ import annotations

import os

# candidates run in processes of their own; threads of the linear algebra under them only get in each other's way
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import sys
from collections.abc import Sequence
from typing import Annotated

import typer

from stribeck.cli import fmu, loops, recordings, withheld
from stribeck.exits import guarded
from stribeck.version import package_version

app = typer.Typer(add_completion=False, rich_markup_mode="rich", pretty_exceptions_enable=False)
for commands in (recordings, loops, fmu):
    app.add_typer(commands.app)
app.add_typer(withheld.app, name="withheld")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the program; return its exit status: 0 done, 2 wrong input or arguments, 130 interrupted, 1 anything else."""
    arguments = list(sys.argv[1:] if arguments is None else arguments)
    return guarded(typer.main.get_command(app), arguments, {**recordings.SPREAD, **fmu.SPREAD, **withheld.SPREAD})


def _show_version(wanted: bool) -> None:
    if wanted:
        print(f"stribeck {package_version()}")
        raise typer.Exit


@app.callback(invoke_without_command=True, epilog="Start with: [bold]stribeck diagnose --example --out out[/bold]")
def _program(
    context: typer.Context,
    show_version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version and exit.")
    ] = False,
    debug: Annotated[bool, typer.Option("--debug", help="Show a traceback when something fails.")] = False,
) -> None:
    """Find where a simulated robot arm departs from the recorded one, name the cause, and correct the model."""
    if context.invoked_subcommand is None:
        print(context.get_help())
