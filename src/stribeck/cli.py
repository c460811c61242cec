"""The program ``stribeck``: one thin function a command. What fails, and how, stands in `stribeck.exits`."""

from __future__ import annotations

import os

# candidates run in processes of their own; threads of the linear algebra under them only get in each other's way
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from stribeck import cli_withheld
from stribeck.arm import Arm, load_arm
from stribeck.errors import InputError
from stribeck.exits import guarded, spread
from stribeck.outputs import check_free, whole_folder
from stribeck.run import Run, load_run, save_columns

app = typer.Typer(add_completion=False, rich_markup_mode="rich", pretty_exceptions_enable=False)
app.add_typer(cli_withheld.app, name="withheld")

ArmFile = Annotated[
    Path | None, typer.Argument(metavar="ARM", help="The nominal arm, a TOML file.", show_default=False)
]
RunFiles = Annotated[
    list[Path] | None, typer.Argument(metavar="RUN", help="Recordings, CSV or Parquet.", show_default=False)
]
HeldOut = Annotated[
    list[Path] | None,
    typer.Option("--held-out", metavar="RUN...", help="Recordings to judge by, never fitted.", show_default=False),
]
OutDir = Annotated[Path, typer.Option("--out", metavar="DIR", help="New folder; written whole or not at all.")]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the program; return its exit status: 0 done, 2 wrong input or arguments, 130 interrupted, 1 anything else."""
    arguments = list(sys.argv[1:] if arguments is None else arguments)
    for option in ("--held-out", "--platforms", *cli_withheld.SPREAD):
        arguments = spread(arguments, option)
    return guarded(typer.main.get_command(app), arguments)


def _show_version(wanted: bool) -> None:
    if wanted:
        print(f"stribeck {version('stribeck')}")
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


@app.command(
    epilog=(
        "Examples:\n\n"
        "[bold]stribeck diagnose --example --out out[/bold] - the recording that comes with the package\n\n"
        "[bold]stribeck diagnose arm.toml run_0*.csv --out out[/bold] - keeps some runs back to judge by\n\n"
        "[bold]stribeck diagnose arm.toml run_0.csv run_1.csv --held-out run_2.csv --out out[/bold]\n\n"
        "Then open out/report.html; out/corrected.toml is the arm with the named effects."
    )
)
def diagnose(
    out: OutDir,
    arm: ArmFile = None,
    runs: RunFiles = None,
    held_out: HeldOut = None,
    example: Annotated[bool, typer.Option("--example", help="Use the recording that comes with the package.")] = False,
    seed: Annotated[int, typer.Option(min=0, help="Of all resampling: the same seed gives the same answer.")] = 0,
    jobs: Annotated[int, typer.Option(min=1, help="Processes that fit candidates at the same time.")] = 2,
) -> None:
    """Say where the gap between arm and recording lies, which effect causes it, and how far it shrinks.

    Writes diagnosis.json, corrected.toml, report.html and the figures.
    """
    check_free(out)
    if example:
        if arm or runs or held_out:
            raise InputError("--example brings its own arm and runs", str(arm or held_out), "leave one of them out")
        arm, runs = _example()
    if arm is None or not runs:
        raise InputError(
            "diagnose needs an arm file and at least one run", "", "or --example; see stribeck diagnose --help"
        )
    nominal = load_arm(arm)
    fitted, judged = _load_runs(nominal, runs, held_out or [])

    from stribeck.gap import diagnose as find
    from stribeck.gap.files import write_diagnosis
    from stribeck.report.diagnosis import write_report
    from stribeck.report.summary import summary

    with whole_folder(out) as folder, _progress("diagnosing") as told:
        found = find(nominal, fitted, judged, seed=seed, jobs=jobs, progress=told)
        told("drawing the report")
        write_diagnosis(found, folder)
        write_report(found, folder)
    console = Console()
    console.print(summary(found))
    console.print(f"report: {out / 'report.html'}", highlight=False, soft_wrap=True)


@app.command(
    epilog="Example: [bold]stribeck predict out/corrected.toml run_03.csv --horizon 0.5 --out ahead.csv[/bold]"
)
def predict(
    model: Annotated[Path, typer.Argument(metavar="MODEL", help="An arm file, nominal or corrected.")],
    run: Annotated[Path, typer.Argument(metavar="RUN", help="A recording, CSV or Parquet.")],
    horizon: Annotated[float, typer.Option("--horizon", metavar="S", help="Length of each simulated window, s.")],
    out: Annotated[Path, typer.Option("--out", metavar="FILE.csv", help="The table to write.")],
) -> None:
    """Start at the recorded state every S seconds and simulate on under the recorded commanded torque."""
    if not 0.0 < horizon < float("inf"):
        raise InputError("--horizon must be a positive time", f"{horizon:g} s", "give seconds, for instance 0.5")
    arm = load_arm(model)
    (recorded,), _ = _load_runs(arm, [run], [])

    from stribeck.simulate.predict import predict as ahead

    prediction = ahead(arm, recorded, horizon)
    columns = {f"{key}{k + 1}": getattr(prediction, key)[:, k] for key in ("q", "dq", "tau") for k in range(arm.n)}
    save_columns({"t": prediction.t, "window": prediction.window, **columns}, out)
    for window in prediction.failed:
        print(f"warning: window {window} ended early: {prediction.status[window]}", file=sys.stderr)


@app.command(epilog="Example: [bold]stribeck identify arm.toml run_*.csv --out out[/bold]")
def identify(
    arm: Annotated[Path, typer.Argument(metavar="ARM", help="The nominal arm, a TOML file.")],
    runs: Annotated[list[Path], typer.Argument(metavar="RUN", help="Recordings, CSV or Parquet.")],
    out: OutDir,
) -> None:
    """Identify each joint's friction, by the paper's Section 3 and by IPOPT.

    Writes fitted.toml, identification.json, report.html and the figure.
    """
    check_free(out)
    nominal = load_arm(arm)
    recorded, _ = _load_runs(nominal, runs, [])

    from stribeck.identify.files import write_identification
    from stribeck.identify.identification import identify as find
    from stribeck.report.identification import summary, write_report

    with whole_folder(out) as folder, _progress("identifying") as told:
        found = find(nominal, recorded, told)
        told("drawing the report")
        write_identification(found, folder)
        write_report(found, folder)
    console = Console()
    console.print(summary(found))
    for text in found.warnings:
        print(f"warning: {text}", file=sys.stderr)
    console.print(f"report: {out / 'report.html'}", highlight=False, soft_wrap=True)


@app.command(
    epilog=(
        "Examples:\n\n"
        "[bold]stribeck simulate arm.toml loop.toml --out out[/bold]\n\n"
        "[bold]stribeck simulate --fmu robot.fmu arm.toml loop.toml --out out[/bold] - the FMU is the robot, and the "
        "arm what its controllers know of it"
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
        typer.Option("--fmu", metavar="FILE", help="Close the loop around this FMU; then ARM may stay inside it."),
    ] = None,
) -> None:
    """Simulate a control loop around the arm; writes simulation.csv (a run), simulation.json and the figures."""
    check_free(out)
    if len(files) != 2 and (fmu is None or len(files) != 1):
        wanted = "an arm file and a loop file" if fmu is None else "a loop file, or an arm file and a loop file"
        raise InputError(f"simulate needs {wanted}", f"{len(files)} files", "see stribeck simulate --help")

    from stribeck.report.simulation import write_figures
    from stribeck.simulate import load_loop
    from stribeck.simulate import simulate as run_loop
    from stribeck.simulate.metrics import write_simulation

    if fmu is None:
        controlled = load_arm(files[0])
        settings = load_loop(files[1], controlled)
        result = run_loop(controlled, settings)
    else:
        from stribeck.export.use import load_fmu_loop, simulate_fmu

        controlled, settings = load_fmu_loop(fmu, files[0] if len(files) == 2 else None, files[-1])
        result = simulate_fmu(fmu, controlled, settings)
    with whole_folder(out) as folder:
        write_simulation(result, controlled, settings, folder)
        write_figures(result, controlled, folder)
    if not result.motion.ok:
        print(f"warning: {result.motion.status} after {result.ended:.6g} s", file=sys.stderr)


@app.command(
    "limit-cycle",
    epilog=(
        "Examples:\n\n"
        "[bold]stribeck limit-cycle arm.toml loop.toml --out out[/bold]\n\n"
        "[bold]stribeck limit-cycle arm.toml loop.toml --grid 101x50 --out out[/bold] - a finer map; --grid none for "
        "none"
    ),
)
def limit_cycle(
    arm: Annotated[Path, typer.Argument(metavar="ARM", help="An arm file, nominal or corrected.")],
    loop: Annotated[Path, typer.Argument(metavar="LOOP", help="A loop file: controllers and references.")],
    out: OutDir,
    grid: Annotated[
        str, typer.Option("--grid", metavar="AxB", help="Cells of the map over k and Kp, or none.")
    ] = "61x31",
) -> None:
    """Say what a control loop ends in: rest or a limit cycle, how large and how stable, and which gains avoid it.

    Writes limit_cycle.json, report.html and the figures.
    """
    check_free(out)
    controlled = load_arm(arm)

    from stribeck.loop.analyse import analyse
    from stribeck.loop.files import write_limit_cycle
    from stribeck.loop.surroundings import grid_of
    from stribeck.report.limit_cycle import summary, write_report
    from stribeck.simulate import load_loop

    settings, cells = load_loop(loop, controlled), grid_of(grid)
    with whole_folder(out) as folder, _progress("analysing") as told:
        found = analyse(controlled, settings, grid=cells, progress=told)
        told("drawing the report")
        write_limit_cycle(found, folder)
        write_report(found, folder)
    console = Console()
    console.print(summary(found))
    console.print(f"report: {out / 'report.html'}", highlight=False, soft_wrap=True)


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
    out: Annotated[Path, typer.Option("--out", metavar="FILE.fmu", help="The FMU to write.")],
    fmi: Annotated[
        int, typer.Option("--fmi", metavar="2|3", help="Version of the standard: 2 is taken by every tool.")
    ] = 2,
    platforms: Annotated[
        list[str] | None,
        typer.Option(
            "--platforms", metavar="NAME...", help="Such as x86_64-linux; all seven without.", show_default=False
        ),
    ] = None,
) -> None:
    """Write an arm as an FMU, for Model Exchange and Co-Simulation, binaries for every platform and sources."""
    arm = load_arm(model)

    from stribeck.export import export_fmu

    with _progress("exporting") as told:
        only_steps = export_fmu(arm, out, fmi=fmi, platforms=platforms or None, progress=told)
    if only_steps:
        print(f"note: {only_steps}", file=sys.stderr)


@app.command("validate-fmu", epilog="Example: [bold]stribeck validate-fmu arm.fmu[/bold]")
def validate(
    fmu: Annotated[Path, typer.Argument(metavar="FILE.fmu", help="An FMU, from here or from any other tool.")],
    run: Annotated[
        bool, typer.Option("--run/--no-run", help="Simulate it, which runs the binary inside: not for untrusted files.")
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


@contextmanager
def _progress(task: str) -> Iterator[Callable[[str], None]]:
    """Show on standard error what is being done; line by line where there is no terminal."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda text: print(f"{task}: {text}", file=sys.stderr, flush=True)
        return
    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        number = bar.add_task(task)
        yield lambda text: bar.update(number, description=text)


def _example() -> tuple[Path, list[Path]]:
    """Return the arm and the runs that come with the package."""
    folder = Path(__file__).with_name("example")
    return folder / "arm.toml", sorted(folder.glob("run_*.csv"))


def _load_runs(arm: Arm, fitted: Sequence[Path], judged: Sequence[Path]) -> tuple[list[Run], list[Run]]:
    """Load the runs of both kinds; a file that is given twice would judge a fit by its own data."""
    seen: set[Path] = set()
    for path in (*fitted, *judged):
        if path.resolve() in seen:
            raise InputError("a run is given twice", str(path), "give each recording once")
        seen.add(path.resolve())
    runs = [load_run(path, arm.n) for path in (*fitted, *judged)]
    for run in runs:
        for text in run.warnings:
            print(f"warning: {run.name}: {text}", file=sys.stderr)
    return runs[: len(fitted)], runs[len(fitted) :]
