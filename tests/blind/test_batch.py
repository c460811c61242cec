"""Answers survive whatever happens to the work: what is done stays, what was lost is done again, nothing is mixed."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import pytest

from stribeck.blind.batch import diagnose_cases
from stribeck.blind.farm import Cluster, Processes
from stribeck.blind.key import open_sealed
from stribeck.blind.score import score
from stribeck.errors import InputError, StribeckError


def scored(answers: Path, key: Path) -> dict:
    """The score, but for how long it took and for source that changes while tests run."""
    result = score(open_sealed(answers, key))
    rows = [{k: v for k, v in row.items() if not k.endswith("seconds")} for row in result.pop("rows")]
    for changing in ("time", "sources"):
        result.pop(changing)
    return {**result, "rows": rows}


@pytest.fixture
def reference(tmp_path, sealed, straw) -> dict:
    diagnose_cases(sealed[0], tmp_path / "reference", farm=Processes(1), diagnoser=straw)
    return scored(tmp_path / "reference", sealed[1])


@pytest.mark.slow  # so does the test of a killed process below, with one death more
def test_processes_give_the_same_score(tmp_path, sealed, straw, reference):
    assert diagnose_cases(sealed[0], tmp_path / "answers", farm=Processes(2), diagnoser=straw) == 10
    assert scored(tmp_path / "answers", sealed[1]) == reference


def test_after_an_interruption_the_same_call_goes_on(tmp_path, sealed, straw_with, reference):
    log = tmp_path / "log"
    log.touch()

    def note(level: float) -> None:
        with log.open("a") as stream:
            stream.write("x")

    def stop(text: str) -> None:
        if text.startswith("4 of 10"):
            raise KeyboardInterrupt

    answers = tmp_path / "answers"
    with pytest.raises(KeyboardInterrupt):
        diagnose_cases(sealed[0], answers, farm=Processes(1), diagnoser=straw_with(note), progress=stop)
    done = {path.name: path.stat().st_mtime_ns for path in answers.glob("case_*.json")}
    assert len(done) == 4
    assert all(path.suffix == ".json" for path in answers.iterdir())  # nothing half written
    told: list[str] = []
    diagnose_cases(sealed[0], answers, farm=Processes(1), diagnoser=straw_with(note), progress=told.append)
    assert told[0] == "4 of 10 cases have their answers already"
    assert all((answers / name).stat().st_mtime_ns == before for name, before in done.items())
    assert len(log.read_text()) <= 11  # at most the one that was running is done twice
    assert scored(answers, sealed[1]) == reference


@pytest.mark.long
def test_a_killed_process_loses_nothing(tmp_path, sealed, straw_with, reference):
    killed = tmp_path / "killed"

    def die_once(level: float) -> None:
        if level == 10.0 and not killed.exists():
            killed.touch()
            os.kill(os.getpid(), signal.SIGKILL)

    diagnose_cases(sealed[0], tmp_path / "answers", farm=Processes(2), diagnoser=straw_with(die_once))
    assert killed.exists()
    assert scored(tmp_path / "answers", sealed[1]) == reference


@pytest.mark.slow
def test_work_that_always_kills_is_reported_and_the_rest_is_kept(monkeypatch, tmp_path, sealed, straw_with):
    monkeypatch.setattr("stribeck.blind.farm.DEATHS", 1)

    def die(level: float) -> None:
        if level == 10.0:
            os.kill(os.getpid(), signal.SIGKILL)

    with pytest.raises(StribeckError, match=r"kills the process that does it: found case_00\d\d;"):
        diagnose_cases(sealed[0], tmp_path / "answers", farm=Processes(2), diagnoser=straw_with(die))
    assert len(list((tmp_path / "answers").glob("case_*.json"))) == 9


def test_a_failure_is_an_answer(tmp_path, sealed, straw_with):
    def fail(level: float) -> None:
        if level == 10.0:
            raise StribeckError("the fit failed", "status 3")

    assert diagnose_cases(sealed[0], tmp_path / "answers", farm=Processes(1), diagnoser=straw_with(fail)) == 10
    result = scored(tmp_path / "answers", sealed[1])
    assert result["failed"]["k"] == 1
    assert [row["error"] for row in result["rows"] if row["error"]] == ["StribeckError: the fit failed: found status 3"]
    assert result["pairs"]["all"]["both"]["k"] == 0


def test_what_failed_or_was_of_other_files_is_done_again(tmp_path, sealed, straw):
    """So is a case that lacked a file: which ones it should have, it does not tell."""
    cases, _ = sealed
    damaged, lacking = cases / "case_0002" / "run_00.csv", cases / "case_0005" / "run_00.csv"
    whole = {path: path.read_bytes() for path in (damaged, lacking)}
    damaged.write_text("t,q1\n")
    lacking.with_name("run_01.csv").write_bytes(whole[lacking].replace(b"\n0,", b"\n0.0,", 1))
    told: list[str] = []
    run = partial(diagnose_cases, cases, tmp_path / "answers", farm=Processes(1), diagnoser=straw, progress=told.append)
    assert run() == 10
    assert any("case_0002: failed, InputError: " in text and "column tau1 is missing" in text for text in told)
    assert told[-1] == "1 of 10 cases failed; the same command tries them again"
    damaged.write_bytes(whole[damaged])
    lacking.with_name("run_01.csv").unlink()
    told.clear()
    assert run() == 10
    assert told[:2] == [
        "8 of 10 cases have their answers already",
        "case_0002, case_0005: failed before, or had other files, and done again",
    ]
    assert len(told) == 4
    assert scored(tmp_path / "answers", sealed[1])["failed"]["k"] == 0
    told.clear()
    assert run() == 10
    assert told == ["10 of 10 cases have their answers already"]


@pytest.mark.parametrize(
    ("file", "says"),
    [
        ("", r"case_x: not a sealed case: found no case\.json"),
        ("case.json", r"case_x.case\.json: schema must be .*; not the note of"),
    ],
)
def test_a_folder_that_is_no_case_is_named(tmp_path, sealed, straw, file, says):
    (sealed[0] / "case_x").mkdir()
    if file:
        (sealed[0] / "case_x" / file).write_text("{}")
    with pytest.raises(InputError, match=says):
        diagnose_cases(sealed[0], tmp_path / "answers", farm=Processes(1), diagnoser=straw)
    assert not (tmp_path / "answers").exists()


def test_answers_of_other_settings_are_not_mixed(tmp_path, sealed, straw):
    answers = tmp_path / "answers"
    diagnose_cases(sealed[0], answers, farm=Processes(1), diagnoser=straw)
    with pytest.raises(InputError, match="begun with other leave_out"):
        diagnose_cases(sealed[0], answers, farm=Processes(1), diagnoser=straw, leave_out=("delay",))
    settings = json.loads((answers / "settings.json").read_text())
    (answers / "settings.json").write_text(json.dumps({**settings, "code": "0"}))
    with pytest.raises(InputError, match="begun with other code: found 0"):
        diagnose_cases(sealed[0], answers, farm=Processes(1), diagnoser=straw)


def test_missing_answers_are_told_or_left_out(tmp_path, sealed, straw):
    answers = tmp_path / "answers"
    diagnose_cases(sealed[0], answers, farm=Processes(1), diagnoser=straw)
    (answers / "case_0002.json").unlink()
    with pytest.raises(InputError, match=r"1 of 10 cases have no answer: found case_0002"):
        open_sealed(answers, sealed[1])
    assert len(open_sealed(answers, sealed[1], partial=True).answers) == 9


def test_an_effect_left_out_everywhere_is_outside_the_library(tmp_path, sealed, straw):
    diagnose_cases(sealed[0], tmp_path / "answers", farm=Processes(1), diagnoser=straw, leave_out=("delay",))
    rows = [row for row in scored(tmp_path / "answers", sealed[1])["rows"] if row["effects"] == ["delay"]]
    assert rows
    assert all((row["kind"], row["why"], row["named"]) == ("outside", "left_out", []) for row in rows)


@pytest.mark.parametrize(
    ("folder", "says"), [("nowhere", "not a folder of sealed cases"), ("other", "not a folder of answers")]
)
def test_wrong_folders_are_refused(tmp_path, sealed, straw, folder, says):
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "mine.txt").touch()
    cases = sealed[0] if folder == "other" else tmp_path / folder
    with pytest.raises(InputError, match=says):
        diagnose_cases(cases, tmp_path / folder, farm=Processes(1), diagnoser=straw)


@contextmanager
def started(*arguments: str) -> Iterator[subprocess.Popen]:
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    process = subprocess.Popen([sys.executable, "-m", "dask", *arguments], **quiet)
    try:
        yield process
    finally:
        process.kill()
        process.wait()


@contextmanager
def cluster(folder: Path, workers: int) -> Iterator[tuple[str, list[subprocess.Popen], subprocess.Popen]]:
    """A scheduler and workers, each a process of its own; give the address and the processes."""
    note = folder / "scheduler.json"
    file, own = (
        ("--scheduler-file", str(note)),
        ("--nthreads", "1", "--no-nanny", "--no-dashboard", "--local-directory"),
    )
    with started("scheduler", "--port", "0", "--host", "127.0.0.1", "--no-dashboard", *file) as scheduler:
        for _ in range(600):
            if note.exists() and note.read_text():
                break
            assert scheduler.poll() is None
            time.sleep(0.05)
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        worker = [sys.executable, "-m", "dask", "worker", *file, *own]
        processes = [subprocess.Popen([*worker, str(folder / f"w{k}")], **quiet) for k in range(workers)]
        try:
            yield json.loads(note.read_text())["address"], processes, scheduler
        finally:
            for process in processes:
                process.kill()
                process.wait()


def wait_for(address: str, workers: int) -> None:
    from distributed import Client

    with Client(address, timeout=60, set_as_default=False) as client:
        client.wait_for_workers(workers, timeout=60)


@pytest.mark.slow  # some ten seconds until all processes stand
@pytest.mark.filterwarnings("default")  # of dask and tornado; none of ours
def test_a_cluster_that_loses_a_worker_gives_the_same_score(tmp_path, sealed, straw_with, reference):

    def linger(level: float) -> None:
        import time

        time.sleep(0.5)

    with cluster(tmp_path, workers=3) as (address, workers, _):
        wait_for(address, 3)
        alive: list[int] = []

        def kill(text: str) -> None:
            if text.startswith("2 of 10"):
                workers[0].kill()
                workers[0].wait()
                alive.append(sum(worker.poll() is None for worker in workers))

        farm = Cluster(address)
        done = diagnose_cases(
            sealed[0], tmp_path / "answers", farm=farm, diagnoser=straw_with(linger), progress=kill
        )  # fmt: skip
    assert alive == [2]
    assert done == 10
    assert scored(tmp_path / "answers", sealed[1]) == reference


@pytest.mark.slow
@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize(("lost", "says"), [("workers", "has no workers"), ("scheduler", "does not answer any more")])
def test_a_cluster_that_is_gone_is_told_and_what_is_done_stays(
    monkeypatch, tmp_path, sealed, straw, straw_with, reference, lost, says
):
    monkeypatch.setattr("stribeck.blind.farm.LOOK", 0.5)
    monkeypatch.setattr("stribeck.blind.farm.WAIT", 4.0)

    def linger(level: float) -> None:
        import time

        time.sleep(0.5)

    with cluster(tmp_path, workers=1) as (address, workers, scheduler):

        def kill(text: str) -> None:
            if text.startswith("2 of 10"):
                victim = workers[0] if lost == "workers" else scheduler
                victim.kill()
                victim.wait()

        wait_for(address, 1)
        with pytest.raises(StribeckError, match=says):
            diagnose_cases(
                sealed[0], tmp_path / "answers", farm=Cluster(address), diagnoser=straw_with(linger), progress=kill
            )
    diagnose_cases(sealed[0], tmp_path / "answers", farm=Processes(1), diagnoser=straw)
    assert scored(tmp_path / "answers", sealed[1]) == reference


def test_no_scheduler_is_told(monkeypatch, tmp_path, sealed, straw):
    monkeypatch.setattr("stribeck.blind.farm.WAIT", 0.3)
    with pytest.raises(InputError, match=r"no scheduler answers: found tcp://127\.0\.0\.1:9"):
        diagnose_cases(sealed[0], tmp_path / "answers", farm=Cluster("tcp://127.0.0.1:9"), diagnoser=straw)


def test_a_cluster_needs_dask(monkeypatch, tmp_path, sealed, straw):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match=r"--cluster needs dask.distributed: .*stribeck\[cluster\]"):
        diagnose_cases(sealed[0], tmp_path / "answers", farm=Cluster("tcp://127.0.0.1:9"), diagnoser=straw)
