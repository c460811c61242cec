"""The commands that take an arm into other tools: ``export-fmu`` and ``validate-fmu``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from stribeck.cli.shared import load_model, progress, warn
from stribeck.outputs import check_keeps

app = typer.Typer()
SPREAD = {"--platforms": "names"}  # takes several values


@app.command(
    "export-fmu",
    epilog=(
        "Examples:\n\n"
        "[bold]stribeck export-fmu arm.toml --out arm.fmu[/bold] - FMI 2.0, every platform\n\n"
        "[bold]stribeck export-fmu corrected.toml --fmi 3 --platforms x86_64-linux x86_64-windows --out arm.fmu[/bold]"
    ),
)
def export(
    model: Annotated[Path, typer.Argument(metavar="MODEL", help="An arm file, nominal or corrected.")],
    out: Annotated[
        Path, typer.Option("--out", metavar="FILE.fmu", help="The FMU to write; one that is there is replaced.")
    ],
    fmi: Annotated[
        int, typer.Option("--fmi", metavar="2|3", help="Version of the standard: 2 is taken by every tool.")
    ] = 2,
    platforms: Annotated[
        list[str] | None,
        typer.Option(
            "--platforms", metavar="NAME...", help="Such as x86_64-linux; default: all seven.", show_default=False
        ),
    ] = None,
) -> None:
    """Write an arm as an FMU, binaries for every platform and sources.

    For Model Exchange and Co-Simulation; an arm with a pure delay for Co-Simulation alone.
    """
    check_keeps(out, [model])
    whole = load_model(model)

    from stribeck.export import export_fmu
    from stribeck.export.notes import notes_of
    from stribeck.model.forward import Forward
    from stribeck.simulate.engine import left_at_null, left_out, path_of
    from stribeck.simulate.foresight import without_foresight

    arm, early = without_foresight(whole)
    warn([*early, *left_out(arm, "it belongs to what reads q and dq from the FMU"), *left_at_null(arm)])
    with progress("exporting") as told:
        only_steps = export_fmu(arm, out, fmi=fmi, platforms=platforms or None, progress=told)
    for note in (*filter(None, [only_steps]), *notes_of(Forward(path_of(arm)))):
        print(f"note: {note}", file=sys.stderr)


@app.command("validate-fmu", epilog="Example: [bold]stribeck validate-fmu arm.fmu[/bold]")
def validate(
    fmu: Annotated[Path, typer.Argument(metavar="FILE.fmu", help="An FMU, from here or from any other tool.")],
    run: Annotated[
        bool,
        typer.Option(
            "--run/--no-run",
            help="Build its sources and simulate it, which runs what is inside: not for untrusted files.",
        ),
    ] = True,
) -> None:
    """Check an FMU: description, binaries, sources, names, units, and its motion against the arm's own simulator.

    Lists the problems; exit status 1 when there are any.
    """
    from stribeck.export.validate import check_fmu
    from stribeck.export.validate.told import told

    found = check_fmu(fmu, run=run)
    for line in told(found):
        print(line)
    if found.problems:
        raise typer.Exit(1)
