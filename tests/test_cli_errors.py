"""The program's failures: exit status, exactly one line on standard error, and nothing left behind."""

import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from io import BytesIO, TextIOWrapper
from pathlib import Path

import numpy as np
import pytest
import typer
from rich.console import Console

from stribeck.cli import main
from stribeck.errors import StribeckError
from stribeck.exits import guarded, spread
from stribeck.outputs import whole_folder
from stribeck.run import Run, load_run, save_run

ARM = """\
schema = "stribeck.arm/1"
name = "bench"
gravity = [0.0, 0.0]
[[joints]]
name = "A"
kind = "revolute"
length = 0.3
mass = 1.0
com = [0.1, 0.0]
inertia = 0.01
rotor_inertia = 0.0
friction = { C0 = 1.0, C1 = 0.0, C2 = 0.1, alpha = 0.1 }
"""


@pytest.fixture
def bench(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder, the current one, with a valid arm.toml and run.csv."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.toml").write_text(ARM)
    t = 0.01 * np.arange(50)
    q = np.sin(t)[:, None]
    save_run(Run("run.csv", t, q, 5 * q), tmp_path / "run.csv")
    return tmp_path


def row(number: int, line: str) -> Callable[[Path], None]:
    def change(bench: Path) -> None:
        lines = (bench / "run.csv").read_text().splitlines()
        lines[number - 1] = line
        (bench / "run.csv").write_text("\n".join(lines) + "\n")

    return change


def content(name: str, data: bytes) -> Callable[[Path], None]:
    return lambda bench: (bench / name).write_bytes(data) and None


def arm(old: str, new: str) -> Callable[[Path], None]:
    return lambda bench: (bench / "arm.toml").write_text(ARM.replace(old, new)) and None


def scaled(factor: float) -> Callable[[Path], None]:
    def change(bench: Path) -> None:
        run = load_run(bench / "run.csv", 1)
        save_run(Run("run.csv", run.t, factor * run.q, run.tau), bench / "run.csv")

    return change


def second_joint(bench: Path) -> None:
    run = load_run(bench / "run.csv", 1)
    save_run(Run("run.csv", run.t, np.tile(run.q, 2), np.tile(run.tau, 2)), bench / "run.csv")


def full_folder(bench: Path) -> None:
    (bench / "out").mkdir()
    (bench / "out" / "mine.txt").touch()


def circle(bench: Path) -> None:
    (bench / "run.csv").unlink()
    (bench / "run.csv").symlink_to("run.csv")


BAD_INPUTS: dict[str, tuple[Callable[[Path], object], str]] = {
    "missing column": (row(1, "t,q1,torque"), "run.csv: column tau1 is missing: found t, q1, torque"),
    "text in a column": (row(7, "0.05,abc,0"), "run.csv: column q1, row 7: not a number: found 'abc'"),
    "nan": (row(7, "0.05,nan,0"), "run.csv: column q1, row 7: not a finite number: found nan"),
    "infinity": (row(7, "0.05,0,inf"), "run.csv: column tau1, row 7: not a finite number: found inf"),
    "empty file": (content("run.csv", b""), "run.csv: the file is empty"),
    "one row": (content("run.csv", b"t,q1,tau1\n0,0,0\n"), "run.csv: has too few samples: found 1"),
    "time backwards": (row(7, "0.01,0,0"), "run.csv: column t, row 7 goes back in time: found 0.01 after 0.04"),
    "duplicate times": (row(7, "0.04,0,0"), "run.csv: column t, row 7 repeats the time"),
    "too many joints": (second_joint, "run.csv: has more joints than the arm"),
    "too few joints": (arm("[[joints]]", ARM[ARM.index("[[") :].replace('"A"', '"B"') + "[[joints]]"), "tau2"),
    "absurd units": (scaled(1e6), "run.csv: column q1 is beyond 1000 rad"),
    "negative mass": (arm("mass = 1.0", "mass = -1.0"), "arm.toml: joints[0].mass must be greater than 0"),
    "unknown key": (arm("mass", "mas"), "arm.toml: joints[0].mas is not a known key; did you mean 'mass'?"),
    "wrong schema": (arm("arm/1", "arm/9"), "arm.toml: schema must be 'stribeck.arm/1': found 'stribeck.arm/9'"),
    "binary arm": (content("arm.toml", b"\x7fELF\0\xff\xfe" * 50), "arm.toml: not a text file"),
    "binary run": (content("run.csv", b"\x7fELF\0\xff\xfe" * 50), "run.csv: is not a CSV file: found binary data"),
    "unreadable arm": (lambda bench: (bench / "arm.toml").unlink(), "arm.toml: cannot be read"),
    "unreadable run": (lambda bench: (bench / "run.csv").unlink(), "run.csv: cannot be read"),
    "links in a circle": (circle, "run.csv: cannot be read"),
    "keys without end": (content("arm.toml", b".".join([b"a"] * 300) + b" = 1"), "a key of more than 100 names"),
    "unknown effect": (
        content("arm.toml", f'{ARM}[[effects]]\neffect = "cable_sprin"\njoints = ["A"]\n'.encode()),
        "arm.toml: effects[0].effect is not a known effect: found 'cable_sprin'; use one of: asymmetric_friction",
    ),
    "output not empty": (full_folder, "out: output folder is not empty"),
    "output is a file": (content("out", b"x"), "out: output folder cannot be made"),
}


@pytest.mark.parametrize("name", BAD_INPUTS)
def test_bad_input(bench: Path, capsys: pytest.CaptureFixture[str], name: str) -> None:
    spoil, says = BAD_INPUTS[name]
    spoil(bench)
    before = sorted(os.listdir(bench))
    assert main(["diagnose", "arm.toml", "run.csv", "--out", "out"]) == 2
    assert_one_line(capsys, says)
    assert sorted(os.listdir(bench)) == before


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ("diagnose", "Missing option '--out'; see stribeck diagnose --help"),
        ("diagnose --out", "requires an argument"),
        ("diagnose --out out", "diagnose needs an arm file and at least one run"),
        ("diagnose arm.toml --out out", "diagnose needs an arm file and at least one run"),
        ("diagnose --held-out run.csv arm.toml run.csv --out out", "give them before --held-out, which takes every"),
        ("diagnose arm.toml --held-out run.csv --out out", "give them before --held-out, which takes every file"),
        ("diagnose arm.toml run.csv --example --out out", "--example brings its own arm and runs"),
        ("diagnose arm.toml run.csv run.csv --out out", "a run is given twice: found run.csv and run.csv"),
        ("diagnose arm.toml run.csv --out out --held-out ./run.csv", "a run is given twice"),
        ("diagnose arm.toml run.csv --out out --outt", "No such option: --outt"),
        ("diagnose arm.toml run.csv --held-out --out out", "--held-out needs files: found --out; give some between"),
        ("diagnose arm.toml run.csv --out out --held-out", "requires an argument"),
        ("withheld", "stribeck: Missing command; see stribeck withheld --help"),
        ("diagnose arm.toml run.csv --torque measured --out out", "run.csv: --torque measured needs tau1_meas"),
        ("diagnose arm.toml run.csv --torque felt --out out", "Invalid value for '--torque'"),
        ("diagnos", "No such command 'diagnos'"),
        ("predict arm.toml run.csv --horizon 0 --out x.csv", "--horizon must be a positive time: found 0 s"),
        ("predict arm.toml run.csv --horizon nan --out x.csv", "--horizon must be a positive time: found nan s"),
        ("predict arm.toml run.csv --horizon soon --out x.csv", "Invalid value for '--horizon'"),
        ("predict arm.toml gone.csv --horizon 1 --out x.csv", "gone.csv: cannot be read"),
    ],
)
def test_bad_arguments(bench: Path, capsys: pytest.CaptureFixture[str], arguments: str, says: str) -> None:
    assert main(arguments.split()) == 2
    assert_one_line(capsys, says)
    assert sorted(os.listdir(bench)) == ["arm.toml", "run.csv"]


@pytest.mark.parametrize("link", [False, True])
@pytest.mark.parametrize(
    ("command", "replaced"),
    [
        ("predict arm.toml run.csv --horizon 0.2 --out", "run.csv"),
        ("predict arm.toml run.csv --horizon 0.2 --out", "arm.toml"),
        ("export-fmu arm.toml --platforms x86_64-linux --out", "arm.toml"),
    ],
)
def test_no_output_replaces_what_is_read(
    bench: Path, capsys: pytest.CaptureFixture[str], command: str, replaced: str, link: bool
) -> None:
    """A recording cannot be made again."""
    before = (bench / replaced).read_bytes()
    out = f"another{Path(replaced).suffix}" if link else f"./{replaced}"
    if link:
        (bench / out).symlink_to(replaced)
    assert main([*command.split(), out]) == 2
    assert_one_line(capsys, f"would replace what is read: found {replaced}; give the output a name of its own")
    assert (bench / replaced).read_bytes() == before


def test_no_prediction_replaces_what_is_there(bench: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (bench / "mine.csv").write_text("mine")
    assert main(["predict", "arm.toml", "run.csv", "--horizon", "0.2", "--out", "mine.csv"]) == 2
    assert_one_line(capsys, "mine.csv: output file exists already; give a new name, or remove this one first")
    assert (bench / "mine.csv").read_text() == "mine"
    assert main(["predict", "arm.toml", "run.csv", "--horizon", "0.2", "--out", "."]) == 2
    assert_one_line(capsys, ".: cannot be written: found a folder; give the name of a file")


def test_a_copy_does_not_judge_its_original(bench: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (bench / "later").mkdir()
    shutil.copy("run.csv", "later/run.csv")
    assert main(["diagnose", "arm.toml", "run.csv", "--held-out", "later/run.csv", "--out", "out"]) == 2
    assert_one_line(capsys, f"a run is given twice: found {bench.name}/run.csv and later/run.csv")
    assert not (bench / "out").exists()


def failing(error: BaseException | None, out: Path, act: Callable[[], object] = lambda: None) -> typer.main.TyperGroup:
    app = typer.Typer()

    @app.callback()
    def program() -> None:
        pass

    @app.command()
    def fail() -> None:
        with whole_folder(out) as folder:
            (folder / "half").touch()
            act()
            if error is not None:
                raise error

    command = typer.main.get_command(app)
    assert isinstance(command, typer.main.TyperGroup)
    return command


@pytest.mark.parametrize(
    ("error", "status", "says"),
    [
        (KeyboardInterrupt(), 130, "interrupted; nothing was written"),
        (StribeckError("the fit failed", "status 3"), 1, "the fit failed: found status 3"),
        (ValueError("a\nb"), 1, "ValueError: a b (add --debug for a traceback)"),
        (OSError(28, "No space left on device"), 2, "out: cannot be written: found no space left on device"),
        (OSError(5, "Input/output error"), 1, "OSError: [Errno 5] Input/output error"),
        (MemoryError(), 1, "MemoryError"),
    ],
)
def test_failure_inside(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], error: BaseException, status: int, says: str
) -> None:
    assert guarded(failing(error, tmp_path / "out"), ["fail"]) == status
    assert_one_line(capsys, says)
    assert os.listdir(tmp_path) == []


def test_debug_shows_a_traceback_wherever_it_stands(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = failing(ValueError("deep"), tmp_path / "out")
    for arguments in (["--debug", "fail"], ["fail", "--debug"]):
        assert guarded(command, arguments) == 1
        assert "Traceback" in capsys.readouterr().err


def test_success_says_nothing_on_standard_error(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert guarded(failing(None, tmp_path / "out"), ["fail"]) == 0
    assert capsys.readouterr().err == ""
    assert os.listdir(tmp_path / "out") == ["half"]


@pytest.mark.parametrize("encoding", ["ascii", "cp1252"])
def test_a_sign_that_the_terminal_lacks_is_replaced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, encoding: str
) -> None:
    shown = BytesIO()
    monkeypatch.setattr("sys.stdout", TextIOWrapper(shown, encoding))
    told = failing(None, tmp_path / "out", lambda: Console().print("re-tuned → corrected"))
    assert guarded(told, ["fail"]) == 0
    sys.stdout.flush()
    assert shown.getvalue().rstrip() == b"re-tuned ? corrected"


def test_help_teaches(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 0
    assert "stribeck diagnose --example --out out" in capsys.readouterr().out
    assert main(["diagnose", "--help"]) == 0
    assert "--held-out" in capsys.readouterr().out
    assert main(["--version"]) == 0
    assert capsys.readouterr().out.startswith("stribeck 0.")


def test_held_out_takes_several_files() -> None:
    given = ["diagnose", "arm", "a", "--held-out", "b", "c", "d", "--out", "o", "e"]
    repeated = ["--held-out", "b", "--held-out", "c", "--held-out", "d"]
    assert spread(given, "--held-out") == ["diagnose", "arm", "a", *repeated, "--out", "o", "e"]
    assert spread(["--held-out"], "--held-out") == ["--held-out"]
    joined = ["diagnose", "arm", "a", "--held-out=b", "c", "--out=o", "e"]
    assert spread(joined, "--held-out") == ["diagnose", "arm", "a", "--held-out=b", "--held-out", "c", "--out=o", "e"]


def test_stop_by_a_batch_system_leaves_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = signal.getsignal(signal.SIGTERM)
    command = failing(None, tmp_path / "out", lambda: os.kill(os.getpid(), signal.SIGTERM))
    assert guarded(command, ["fail"]) == 130
    assert_one_line(capsys, "interrupted")
    assert os.listdir(tmp_path) == []
    assert signal.getsignal(signal.SIGTERM) is before


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_stop_whose_exception_is_lost_writes_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], number: int
) -> None:
    """A library that clears what is raised inside it must not make an answer of what was cut short."""

    def cleared() -> None:
        with suppress(KeyboardInterrupt):
            os.kill(os.getpid(), number)

    assert guarded(failing(None, tmp_path / "out", cleared), ["fail"]) == 130
    assert_one_line(capsys, "interrupted; nothing was written")
    assert os.listdir(tmp_path) == []
    assert guarded(failing(None, tmp_path / "out"), ["fail"]) == 0  # it was that command's


@pytest.mark.parametrize("lost", [False, True])
def test_a_stop_while_the_program_is_imported_is_told_in_one_line(lost: bool) -> None:
    """Also where a package makes an error of its own of it."""
    code = """
import os, runpy, signal, sys

class Stop:
    def find_spec(name, *where):
        if name == "typer":
            try:
                os.kill(os.getpid(), signal.SIGINT)
            except KeyboardInterrupt:
                if LOST:
                    raise ImportError("half a package")
                raise

sys.meta_path.insert(0, Stop)
runpy.run_module("stribeck", run_name="__main__")
"""
    done = subprocess.run(
        [sys.executable, "-c", code.replace("LOST", str(lost)), "--version"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (130, "stribeck: interrupted\n")


def assert_one_line(capsys: pytest.CaptureFixture[str], says: str) -> None:
    captured = capsys.readouterr()
    assert captured.err.startswith("stribeck: ")
    assert captured.err.count("\n") == 1
    assert captured.err.endswith("\n")
    assert says in captured.err
    assert captured.out == ""


def test_the_module_is_the_program(bench: Path) -> None:
    """``python -m stribeck`` takes the same arguments and ends with the same status."""
    told = subprocess.run(
        [sys.executable, "-m", "stribeck", "predict", "none.toml", "run.csv", "--horizon", "1", "--out", "p.csv"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert told.returncode == 2
    assert "none.toml" in told.stderr
