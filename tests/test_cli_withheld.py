"""``stribeck withheld ...``: the whole way on cases of straw, and its failures in one line."""

import json
import re
from pathlib import Path

import pytest

import stribeck
from stribeck.cli import main

EXAMPLE = Path(stribeck.__file__).parent / "example"


def call(arguments: str) -> int:
    return main(["withheld", *arguments.split()])


def straw(arm, runs, leave_out):
    """Name a delay wherever the arm moves; quick, and as blind as can be."""
    cause = {
        "effect": "delay", "joints": ["A"], "probability": 0.9, "presence": 0.9, "equivalent": ["delay"],
        "parameters": {}, "closes": None,
    }  # fmt: skip
    rest = {"effect": "unknown", "probability": 0.1}
    return {
        "diagnosis": {"verdict": "explained", "named": ["delay"], "causes": [cause, rest], "where": [],
                      "gap": {"closed": None}, "settings": {"cutoff_hz": 10.0}},
        "retuned": "", "corrected": "",
    }  # fmt: skip


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    from stribeck.blind import batch

    monkeypatch.setitem(batch.diagnose_cases.__kwdefaults__, "diagnoser", straw)
    return tmp_path


@pytest.fixture
def undrawn(monkeypatch):
    """Figures are laid out, but not made into images."""
    monkeypatch.setattr("stribeck.report.withheld.png_and_svg", lambda figure: (b"", b""))


@pytest.mark.long
@pytest.mark.usefixtures("undrawn")
def test_the_whole_way(here, capsys):
    order = "--cases 2 --none 1 --effects delay torque_offset --levels clear --joints 1 --seed 1 --jobs 1"
    assert call(f"record {order} --out cases --key key.json") == 0
    digest = capsys.readouterr().out.split()[0]
    assert (here / "cases" / "digest.txt").read_text().startswith(digest)
    assert call("diagnose cases --out answers --jobs 1") == 0
    assert call("score answers --key key.json --out score --jobs 1") == 0
    out = capsys.readouterr().out
    assert "wrong name, of all single effects: 1 of 2 (50 %; at most 3 % asked)" in out.replace("\u00a0", " ")
    score = json.loads((here / "score" / "score.json").read_text())
    assert (score["digest"], score["cases"]) == (digest, 3)
    assert score["none"]["false_alarms"]["value"] == 1.0
    assert (here / "score" / "report.html").exists()


@pytest.mark.slow
def test_power(here, capsys):
    run = EXAMPLE / "run_01.csv"
    short = here / "run.csv"
    short.write_text("\n".join(run.read_text().splitlines()[:800]) + "\n")
    options = "--out power --effects delay --levels clear --none 0 --jobs 1"
    assert call(f"power {EXAMPLE / 'arm.toml'} run.csv {options}") == 0
    assert "delay: revealed where clear" in capsys.readouterr().out
    assert json.loads((here / "power" / "power.json").read_text())["effects"]["delay"]["revealed_from"] == "clear"
    assert sorted(path.name for path in here.iterdir()) == ["power", "run.csv"]


@pytest.mark.long
def test_the_own_arm_is_recorded(here, capsys):
    arm, run = str(EXAMPLE / "arm.toml"), str(EXAMPLE / "run_01.csv")
    options = "--cases 1 --effects delay --levels clear --out cases --key key.json --jobs 1"
    assert call(f"record {options} --arm {arm} --runs {run}") == 0
    assert (here / "cases" / "case_0001" / "arm.toml").read_text() == Path(arm).read_text()


def test_an_interruption_says_that_nothing_is_lost(here, capsys, monkeypatch):
    assert call("record --none 1 --joints 1 --seed 1 --jobs 1 --out cases --key key.json") == 0

    def stop(*args):
        raise KeyboardInterrupt

    from stribeck.blind import batch

    monkeypatch.setitem(batch.diagnose_cases.__kwdefaults__, "diagnoser", stop)
    assert call("diagnose cases --out answers --jobs 1") == 130
    assert "0 answers are in answers, the same command goes on" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ("record --out cases --key key.json", "no cases to record: found 0; give --cases"),
        ("record --cases 1 --out cases", "Missing option '--key'"),
        ("record --cases 1 --out cases --key cases/key.json", "the key would lie among the cases"),
        ("record --cases 1 --effects dely --out cases --key key.json", "the plant has no such effect: found dely"),
        ("record --cases 1 --out cases --key key.json --arm arm.toml", "--arm and --runs belong together: found --arm"),
        (
            "record --cases 1 --joints 3 --out cases --key key.json --arm arm.toml --runs run.csv",
            "--joints is for drawn arms: found --joints 3 with --arm; leave it out",
        ),
        ("diagnose nowhere --out answers", "nowhere: not a folder of sealed cases"),
        ("score nowhere --key key.json --out score", "settings.json: cannot be read"),
        ("power gone.toml run.csv --out power", "gone.toml: cannot be read"),
        (
            f"power {EXAMPLE / 'arm.toml'} {EXAMPLE / 'run_01.csv'} --out power --cluster foo",
            "--cluster: no scheduler answers: found foo",
        ),
        ("guess", "No such command 'guess'"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(here, capsys, arguments, says):
    assert call(arguments) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert re.search(re.escape(says), line)
    assert list(here.iterdir()) == []
