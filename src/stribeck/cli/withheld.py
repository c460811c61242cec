"""The commands ``stribeck withheld ...``: the check on data whose effect is withheld."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from stribeck.cli.shared import check_library, load_model, read_runs, tell, unless_asked
from stribeck.errors import InputError
from stribeck.exits import INTERRUPTED
from stribeck.outputs import check_free, whole_folder

if TYPE_CHECKING:
    from stribeck.arm import Arm
    from stribeck.blind.farm import Farm
    from stribeck.run import Run

app = typer.Typer()

Out = Annotated[Path, typer.Option("--out", metavar="DIR", help="New folder; written whole or not at all.")]
Answers = Annotated[Path, typer.Option("--out", metavar="RESULTS", help="New folder, or one to go on with.")]
Key = Annotated[Path, typer.Option("--key", metavar="FILE", help="The sealed answers; keep it away from the cases.")]
Jobs = Annotated[int, typer.Option(min=1, help="Processes on this machine.")]
Address = Annotated[
    str | None,
    typer.Option("--cluster", metavar="ADDRESS", help="Of a dask scheduler, whose workers then do the work."),
]
Names = list[str] | None
SPREAD = {"--effects": "names", "--levels": "names", "--leave-out": "names", "--runs": "files"}  # several values


@app.callback()
def _group() -> None:
    """Record cases with hidden effects, diagnose them without the answers, and score what was said."""


@app.command(
    epilog=(
        "Example: [bold]stribeck withheld record --cases 60 --none 20 --unknown 12 --pairs 12 --out cases "
        "--key key.json[/bold]"
    )
)
def record(
    out: Out,
    key: Key,
    cases: Annotated[int, typer.Option(min=0, help="Cases with one effect each.")] = 0,
    none: Annotated[int, typer.Option(min=0, help="Cases without; coloured noise shakes every third of them.")] = 0,
    unknown: Annotated[int, typer.Option(min=0, help="Cases with an effect that no library holds.")] = 0,
    pairs: Annotated[int, typer.Option(min=0, help="Cases with two effects.")] = 0,
    left_out: Annotated[int, typer.Option(min=0, help="Cases whose effect is withheld from the library.")] = 0,
    several: Annotated[int, typer.Option(min=0, help="Cases with three to five effects.")] = 0,
    effects: Annotated[Names, typer.Option("--effects", metavar="NAME...", help="To draw from; default: all.")] = None,
    levels: Annotated[
        Names,
        typer.Option("--levels", metavar="NAME...", help="Strengths to use: clear, medium, weak; default: all three."),
    ] = None,
    joints: Annotated[int, typer.Option(min=0, max=4, help="Joints of each random arm; 0: one or two, at random.")] = 0,
    arm: Annotated[
        Path | None, typer.Option("--arm", metavar="ARM", help="Record your own arm, not drawn ones.")
    ] = None,
    runs: Annotated[
        list[Path] | None, typer.Option("--runs", metavar="RUN...", help="And your own motions, with --arm.")
    ] = None,
    seed: Annotated[int | None, typer.Option(min=0, help="Of all random numbers; a random one by default.")] = None,
    jobs: Jobs = 2,
) -> None:
    """Record cases with an independent plant; print the digest of the sealed answers."""
    check_free(out)
    if bool(arm) != bool(runs):
        raise InputError("--arm and --runs belong together", "--arm" if arm else "--runs", "give both or none")
    if arm and joints:
        raise InputError("--joints is for drawn arms", f"--joints {joints} with --arm", "leave it out")
    own = _experiment(arm, runs) if arm and runs else None

    from stribeck.withheld.injections import KNOWN
    from stribeck.withheld.own import own_maker
    from stribeck.withheld.plan import JOINTS, LEVELS, Order
    from stribeck.withheld.seal import drawn_case, record_sealed

    maker = own_maker(*own) if own else None
    known = maker.effects(effects or ()) if maker else tuple(effects or KNOWN)
    order = Order(
        cases, pairs, none, unknown, left_out, known, tuple(levels or LEVELS),
        (joints,) if joints else JOINTS, several,
    )  # fmt: skip
    make = maker or drawn_case
    digest = record_sealed(order, out, key, seed=seed, jobs=jobs, make=make, progress=_told("recording"))
    print(f"{digest}  SHA-256 of the sealed answers, {key}")
    tell(maker.notes if maker else ())


@app.command(epilog="Example: [bold]stribeck withheld diagnose cases --out answers[/bold]; once more to go on")
def diagnose(
    cases: Annotated[Path, typer.Argument(metavar="DIR", help="What withheld record wrote.")],
    out: Answers,
    leave_out: Annotated[
        Names, typer.Option("--leave-out", metavar="NAME...", help="Effects withheld from the library.")
    ] = None,
    jobs: Jobs = 2,
    cluster: Address = None,
) -> None:
    """Diagnose every case without its answer; a second call goes on, and tries what failed again."""
    check_library()

    from stribeck.blind.batch import diagnose_cases

    with _resumable(out):
        diagnose_cases(cases, out, farm=_farm(jobs, cluster), leave_out=leave_out or (), progress=_told("diagnosing"))


@app.command(epilog="Example: [bold]stribeck withheld score answers --key key.json --out score[/bold]")
def score(
    results: Annotated[Path, typer.Argument(metavar="RESULTS", help="What withheld diagnose wrote.")],
    key: Key,
    out: Out,
    partial: Annotated[
        bool, typer.Option("--partial", help="Score the cases that have answers, if some lack.")
    ] = False,
    shrinkage: Annotated[bool, typer.Option(help="Judge corrected models on new motions of the same arms.")] = True,
    jobs: Jobs = 2,
) -> None:
    """Open the key and say how often the diagnosis was right, and whether its probabilities were."""
    check_free(out)

    from stribeck.blind.batch import write_json
    from stribeck.blind.key import open_sealed
    from stribeck.blind.score import score as scored
    from stribeck.blind.shrinkage import true_shrinkage
    from stribeck.report.withheld import write_score_report
    from stribeck.report.withheld_tables import told

    opened = open_sealed(results, key, partial=partial)
    truly = true_shrinkage(opened, jobs, _told("scoring")) if shrinkage else None
    result = scored(opened, truly)
    with whole_folder(out) as folder:
        write_json(folder / "score.json", result)
        write_score_report(result, folder)
    for line in result["targets"]:
        if line["have"] is not None:
            print(told(line))
    print(f"report: {out / 'report.html'}")


@app.command(epilog="Example: [bold]stribeck withheld power arm.toml run_0*.csv --out power[/bold]")
def power(
    arm: Annotated[Path, typer.Argument(metavar="ARM", help="Your nominal arm.")],
    runs: Annotated[list[Path], typer.Argument(metavar="RUN...", help="Your recordings; their motions are used.")],
    out: Out,
    effects: Annotated[Names, typer.Option("--effects", metavar="NAME...", help="To try; default: all.")] = None,
    levels: Annotated[
        Names,
        typer.Option("--levels", metavar="NAME...", help="Strengths to use: clear, medium, weak; default: all three."),
    ] = None,
    each: Annotated[int, typer.Option(min=1, help="Cases of each effect and level.")] = 1,
    none: Annotated[int, typer.Option(min=0, help="Cases without an effect.")] = 4,
    seed: Annotated[int, typer.Option(min=0, help="Of all random numbers: the same seed gives the same cases.")] = 0,
    jobs: Jobs = 2,
    cluster: Address = None,
) -> None:
    """Say which effects, and how strong, your own arm and motions would reveal; one diagnosis a case takes its time."""
    check_free(out)
    check_library()
    own_arm, recordings = _experiment(arm, runs)

    from stribeck.blind.batch import write_json
    from stribeck.blind.power import power_analysis
    from stribeck.report.power import write_power_report
    from stribeck.withheld.plan import LEVELS

    work = out.absolute().parent / f".{out.name}.work"
    with _resumable(work / "answers"):
        found, scored = power_analysis(
            own_arm, recordings, work, effects=effects or (), levels=levels or LEVELS, each=each, none=none, seed=seed,
            jobs=jobs, farm=_farm(jobs, cluster), progress=_told("power"),
        )  # fmt: skip
    with whole_folder(out) as folder:
        write_json(folder / "power.json", found)
        write_json(folder / "score.json", scored)
        write_power_report(found, scored, folder)
    shutil.rmtree(work, ignore_errors=True)
    for name, row in found["effects"].items():
        print(f"{name}: {'revealed where ' + row['revealed_from'] if row['revealed_from'] else 'not revealed'}")
    for name in found["not_recorded"]:
        print(f"{name}: could not be recorded")
    tell(found["notes"])
    print(f"report: {out / 'report.html'}")


def _experiment(arm: Path, runs: Sequence[Path]) -> tuple[Arm, list[Run]]:
    nominal = load_model(arm)
    return nominal, read_runs(nominal, runs)[0]


def _farm(jobs: int, cluster: str | None) -> Farm:
    from stribeck.blind.farm import Cluster, Processes

    if not cluster:
        return Processes(jobs)
    farm = Cluster(cluster)
    farm.check()  # before cases are recorded for it
    return farm


@contextmanager
def _resumable(out: Path) -> Iterator[None]:
    """Say after Ctrl-C what the program at large cannot know: that nothing done is lost."""
    try:
        yield
    except KeyboardInterrupt:
        done = len(list(out.glob("case_*.json")))
        print(f"stribeck: interrupted; {done} answers are in {out}, the same command goes on", file=sys.stderr)
        raise typer.Exit(INTERRUPTED) from None


def _told(task: str) -> Callable[[str], None]:
    """Show on standard error what is being done, line by line."""
    console = Console(stderr=True)
    return unless_asked(lambda text: console.print(f"{task}: {text}", highlight=False, markup=False, soft_wrap=True))
