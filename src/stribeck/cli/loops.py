"""The commands that close a control loop around the arm: ``simulate`` and ``limit-cycle``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from stribeck.cli.shared import OutDir, load_model, progress, tell, warn
from stribeck.errors import InputError
from stribeck.outputs import check_free, whole_folder

app = typer.Typer()
FORMATS = (
    "Formats: README.md of the source, sections The arm file and The loop file, an annotated example each. A short "
    "example: fmu/two_link_nominal/arm.toml with loop.toml beside it."
)


@app.command(
    epilog=(
        "Examples:\n\n"
        "[bold]stribeck simulate arm.toml loop.toml --out out[/bold]\n\n"
        "[bold]stribeck simulate --fmu robot.fmu arm.toml loop.toml --out out[/bold] - the FMU is the robot, and the "
        "arm what its controllers know of it\n\n" + FORMATS
    )
)
def simulate(
    files: Annotated[
        list[Path],
        typer.Argument(
            metavar="ARM LOOP", help="An arm file, nominal or corrected, and a loop file.", show_default=False
        ),
    ],
    out: OutDir,
    fmu: Annotated[
        Path | None,
        typer.Option(
            "--fmu",
            metavar="FILE",
            help="Close the loop around this FMU; then ARM may be left out: the FMU holds its own.",
        ),
    ] = None,
) -> None:
    """Simulate a control loop around the arm; writes simulation.csv (a run), simulation.json and the figures."""
    check_free(out)
    if len(files) != 2 and (fmu is None or len(files) != 1):
        wanted = "an arm file and a loop file" if fmu is None else "a loop file, or an arm file and a loop file"
        raise InputError(f"simulate needs {wanted}", f"{len(files)} files", "see stribeck simulate --help")

    from stribeck.report.simulation import write_figures
    from stribeck.simulate import read_loop
    from stribeck.simulate import simulate_loop as run_loop
    from stribeck.simulate.engine import left_out
    from stribeck.simulate.foresight import without_foresight
    from stribeck.simulate.metrics import limited, stopped, told, write_simulation

    if fmu is None:
        controlled, early = without_foresight(load_model(files[0]))
        settings, notes, doubts = read_loop(files[1], controlled)
        warn([*left_out(controlled), *early, *doubts])
        result = run_loop(controlled, settings)
    else:
        from stribeck.export.use import load_fmu_loop, simulate_fmu

        controlled, settings, notes, doubts = load_fmu_loop(fmu, files[0] if len(files) == 2 else None, files[-1])
        warn(doubts)
        result = simulate_fmu(fmu, controlled, settings)
    with whole_folder(out) as folder:
        write_simulation(result, controlled, settings, folder)
        write_figures(result, controlled, folder)
    warn(limited(result, controlled))
    print(told(result, controlled))
    tell(notes)
    print(f"{out}: simulation.csv, simulation.json and motion_*.png")
    warn(stopped(result, settings))


@app.command(
    "limit-cycle",
    epilog=(
        "Examples:\n\n"
        "[bold]stribeck limit-cycle arm.toml loop.toml --out out[/bold]\n\n"
        "[bold]stribeck limit-cycle arm.toml loop.toml --grid 101x50 --out out[/bold] - a finer map; --grid none for "
        "none\n\n" + FORMATS
    ),
)
def limit_cycle(
    arm: Annotated[Path, typer.Argument(metavar="ARM", help="An arm file, nominal or corrected.")],
    loop: Annotated[Path, typer.Argument(metavar="LOOP", help="A loop file: controllers and references.")],
    out: OutDir,
    grid: Annotated[
        str,
        typer.Option("--grid", metavar="AxB", help="Cells of the map over k and Kp, 100000 at most in all; or none."),
    ] = "61x31",
) -> None:
    """Say what a control loop ends in: rest or a limit cycle, how large and how stable, and which gains avoid it.

    Writes limit_cycle.json, report.html and the figures.
    """
    check_free(out)
    model = load_model(arm)

    from stribeck.effects.undriven import undriven
    from stribeck.loop.analyse import analyse_loop
    from stribeck.loop.files import write_limit_cycle
    from stribeck.loop.surroundings import grid_of
    from stribeck.report.limit_cycle import summary, write_report
    from stribeck.simulate import read_loop
    from stribeck.simulate.engine import left_out
    from stribeck.simulate.foresight import without_foresight

    controlled, early = without_foresight(model)
    (settings, notes, doubts), cells = read_loop(loop, controlled), grid_of(grid)
    warn([*left_out(controlled), *early, *undriven(controlled)[1], *doubts])
    with whole_folder(out) as folder, progress("analysing") as told:
        found = analyse_loop(controlled, settings, grid=cells, progress=told)
        told("drawing the report")
        write_limit_cycle(found, folder)
        write_report(found, folder)
    console = Console()
    console.print(summary(found))
    tell(notes)
    console.print(f"report: {out / 'report.html'}", highlight=False, soft_wrap=True)
