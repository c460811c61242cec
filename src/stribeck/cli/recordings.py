"""The commands that read recordings: ``diagnose``, ``predict`` and ``identify``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from enum import StrEnum
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from stribeck.arm import Arm, doubtful_values, unit_at
from stribeck.cli.shared import OutDir, check_library, doubts, load_model, progress, read_runs, tell, warn
from stribeck.errors import InputError
from stribeck.outputs import check_free, check_keeps, check_new, whole_folder
from stribeck.run import Run, save_columns

if TYPE_CHECKING:
    from stribeck.simulate.predict import Prediction

app = typer.Typer()
SPREAD = {"--held-out": "files"}  # takes several values

ArmFile = Annotated[
    Path | None, typer.Argument(metavar="ARM", help="The nominal arm, a TOML file.", show_default=False)
]
RunFiles = Annotated[
    list[Path] | None,
    typer.Argument(
        metavar="RUN",
        help="Recordings, CSV or Parquet: t (s), q1.. (rad), tau1.. (N m, commanded).",
        show_default=False,
    ),
]
HeldOut = Annotated[
    list[Path] | None,
    typer.Option(
        "--held-out",
        metavar="RUN...",
        help="Recordings to judge by, never fitted: every file up to the next option.",
        show_default=False,
    ),
]


class Torque(StrEnum):
    """Which torque of a recording drives the model."""

    commanded = "commanded"
    measured = "measured"


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
    torque: Annotated[
        Torque, typer.Option(help="Take tau1, .. (what the controller asked for) or tau1_meas, .. as the torque.")
    ] = Torque.commanded,
    seed: Annotated[int, typer.Option(min=0, help="Of the random numbers: the same seed gives the same answer.")] = 0,
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
        do = "give them before --held-out, which takes every file up to the next option"
        do = do if held_out else "or --example; see stribeck diagnose --help"
        raise InputError("diagnose needs an arm file and at least one run", "", do)
    check_library()
    nominal = load_model(arm)
    fitted, judged = read_runs(nominal, runs, held_out or [])
    said = [*doubtful_values(nominal), *doubts((*fitted, *judged))]

    if torque is Torque.measured:
        fitted, judged = _measured(fitted), _measured(judged)
    from stribeck.gap import diagnose as find
    from stribeck.gap.answer.files import write_diagnosis
    from stribeck.report.diagnosis import write_report
    from stribeck.report.summary import summary

    with whole_folder(out) as folder, progress("diagnosing") as told:
        found = find(nominal, fitted, judged, seed=seed, jobs=jobs, progress=told)
        told("drawing the report")
        write_diagnosis(found, folder)
        write_report(found, folder)
    console = Console()
    console.print(summary(found, said))
    console.print(f"report: {out / 'report.html'}", highlight=False, soft_wrap=True)


@app.command(
    epilog="Example: [bold]stribeck predict out/corrected.toml run_03.csv --horizon 0.5 --out ahead.csv[/bold]"
)
def predict(
    model: Annotated[Path, typer.Argument(metavar="MODEL", help="An arm file, nominal or corrected.")],
    run: Annotated[
        Path,
        typer.Argument(metavar="RUN", help="A recording, CSV or Parquet: t (s), q1.. (rad), tau1.. (N m, commanded)."),
    ],
    horizon: Annotated[float, typer.Option("--horizon", metavar="S", help="Length of each simulated window, s.")],
    out: Annotated[
        Path, typer.Option("--out", metavar="FILE.csv", help="The table to write; it must not be there yet.")
    ],
) -> None:
    """Start at the recorded state every S seconds and simulate on under the recorded commanded torque."""
    check_keeps(out, (model, run))
    check_new(out)
    if not 0.0 < horizon < float("inf"):
        raise InputError("--horizon must be a positive time", f"{horizon:g} s", "give seconds, for instance 0.5")
    arm = load_model(model)
    (recorded,), _ = read_runs(arm, [run])

    from stribeck.simulate.predict import predict as ahead

    prediction = ahead(arm, recorded, horizon)
    columns = {f"{key}{k + 1}": getattr(prediction, key)[:, k] for key in ("q", "dq", "tau") for k in range(arm.n)}
    save_columns({"t": prediction.t, "window": prediction.window, **columns}, out)
    tell(prediction.notes)
    said = [*doubtful_values(arm), *doubts([recorded])]
    warn([text for text in prediction.warnings if text not in said])
    warn([f"window {window} ended early: {prediction.status[window]}" for window in prediction.failed])
    _tell_prediction(prediction, arm, horizon, out)


@app.command(epilog="Example: [bold]stribeck identify arm.toml run_*.csv --out out[/bold]")
def identify(
    arm: Annotated[Path, typer.Argument(metavar="ARM", help="The nominal arm, a TOML file.")],
    runs: Annotated[
        list[Path],
        typer.Argument(metavar="RUN", help="Recordings, CSV or Parquet: t (s), q1.. (rad), tau1.. (N m, commanded)."),
    ],
    out: OutDir,
) -> None:
    """Identify each joint's friction, by the paper's Section 3 and by IPOPT.

    Writes fitted.toml, identification.json, report.html and the figure.
    """
    check_free(out)
    nominal = load_model(arm)
    recorded, _ = read_runs(nominal, runs)

    from stribeck.identify.files import write_identification
    from stribeck.identify.identification import identify_friction as find
    from stribeck.report.identification import summary, write_report

    with whole_folder(out) as folder, progress("identifying") as told:
        found = find(nominal, recorded, told)
        told("drawing the report")
        write_identification(found, folder)
        write_report(found, folder)
    console = Console()
    console.print(summary(found))
    said = [*doubtful_values(nominal), *doubts(recorded)]
    warn([text for text in found.warnings if text not in said])
    console.print(f"report: {out / 'report.html'}", highlight=False, soft_wrap=True)


def _tell_prediction(prediction: Prediction, arm: Arm, horizon: float, out: Path) -> None:
    """Say what was written, and how near it is to the recording."""
    count = len(prediction.status)
    print(f"{out}: {count} window{'s' * (count != 1)} of up to {horizon:g} s")
    figures = ("motion", prediction.motion_error, "rad"), ("torque", prediction.torque_error, "N m")
    told = [
        f"{what} {error[j]:.3g} {unit_at(unit, joint.kind)} at {joint.name}"
        for what, error, unit in figures
        if error is not None
        for j, joint in enumerate(arm.joints)
    ]
    print(f"rms error: {', '.join(told)}")


def _measured(runs: Sequence[Run]) -> list[Run]:
    """Return runs whose measured torque stands in for the command."""
    from stribeck.gap.answer.delivered import as_commanded

    for run in runs:
        if run.tau_meas is None:
            raise InputError(f"{run.name}: --torque measured needs tau1_meas, ..", "no such column", "leave it out")
    said = "its measured torque stands in for the command"
    return [replace(as_commanded(run), tau_meas=None, warnings=(*run.warnings, said)) for run in runs]


def _example() -> tuple[Path, list[Path]]:
    """Return the arm and the runs that come with the package."""
    folder = Path(str(files("stribeck") / "example"))
    return folder / "arm.toml", sorted(folder.glob("run_*.csv"))
