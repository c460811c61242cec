import ast
import importlib
import json
import math
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from stribeck.gap.result import Cause, Estimate

STUDIES = Path(__file__).parents[2] / "studies"
NAMES = sorted(path.stem for path in STUDIES.glob("[!_]*.py"))


def test_there_are_studies():
    assert {"blind_effects", "real_pendulum", "record_example", "speed"} <= set(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_a_study_says_what_it_asks_how_and_what_to_expect(name):
    text = ast.get_docstring(ast.parse((STUDIES / f"{name}.py").read_text(encoding="utf-8")))
    assert text is not None
    assert text.startswith("Question: ")
    assert "?" in text.splitlines()[0]
    assert "\nMethod: " in text
    assert "\nExpected: " in text


@pytest.mark.parametrize("name", NAMES)
def test_a_study_is_short_and_does_nothing_when_it_is_imported(name, tmp_path, capfd):
    source = (STUDIES / f"{name}.py").read_text(encoding="utf-8")
    assert source.count("\n") <= 80
    last = ast.parse(source).body[-1]
    assert isinstance(last, ast.If)
    assert ast.unparse(last.test) == "__name__ == '__main__'"
    importlib.import_module(name)
    assert capfd.readouterr() == ("", "")
    assert not (tmp_path / "out").exists()


def test_outputs_of_studies_are_not_committed():
    lines = (STUDIES.parent / ".gitignore").read_text(encoding="utf-8").splitlines()
    assert "/studies/out/" in lines


@pytest.mark.slow  # and only on the kind of machine that recorded it: others round sines differently
def test_recording_the_example_again_gives_the_same_bytes(tmp_path):
    study = importlib.import_module("record_example")
    made_at = tmp_path / "src/stribeck/example"
    made_at.parent.mkdir(parents=True)
    study.write_example(made_at, tmp_path / "truth.json")
    shipped = study.ROOT / "src/stribeck/example"
    made = sorted(path.name for path in made_at.iterdir())
    assert made == sorted(path.name for path in shipped.iterdir() if path.suffix in (".toml", ".csv"))
    for name in made:
        assert (made_at / name).read_bytes() == (shipped / name).read_bytes(), name
    truth = study.ROOT / "tests/withheld/example_truth.json"
    assert (tmp_path / "truth.json").read_bytes() == truth.read_bytes()


def test_results_are_json_whatever_the_numbers(tmp_path):
    import _output

    folder = _output.write("some", {"a": math.nan, "b": (1.0 / 3.0, True, 2), "c": {"d": None}}, nothing=None)
    assert json.loads((folder / "result.json").read_text()) == {"a": None, "b": [0.333333, True, 2], "c": {"d": None}}
    assert [path.name for path in folder.iterdir()] == ["result.json"]


def found(*causes, named=None):
    names = tuple(cause.effect for cause in causes) if named is None else named
    return SimpleNamespace(causes=causes, named=names, verdict="explained", closed=Estimate(0.9, 0.8, 1.0))


DELAY = Cause("delay", 0.9, ("A",), ("delay",), {"A": {"time": Estimate(0.011, 0.010, 0.012, "s")}}, presence=0.9)
LAG = Cause("actuator_lag", 0.9, ("A",), ("actuator_lag", "delay"), presence=0.9)
GAIN = Cause("torque_gain", 0.6, ("B",), ("torque_gain",), presence=0.6)
TRUTH = ({"effect": "delay", "joint": "A", "parameters": {"time": 0.0115}},)


@pytest.mark.parametrize(
    ("diagnosis", "outcome", "extra"),
    [
        (found(DELAY), "right", []),
        (found(LAG), "right in a class", []),
        (found(DELAY, GAIN), "right, and more", ["torque_gain"]),
        (found(GAIN), "wrong", ["torque_gain"]),
        (found(DELAY, named=()), "missed", []),
        (found(), "missed", []),
    ],
)
def test_a_name_counts_when_it_or_its_equivalent_is_true(diagnosis, outcome, extra):
    from _scoring import score

    row = score(diagnosis, TRUTH)
    assert (row["outcome"], row["extra"]) == (outcome, extra)


def test_joint_and_interval_are_scored():
    from _scoring import score

    row = score(found(DELAY), TRUTH)
    assert row["joint_right"] is True
    assert [(p["name"], p["inside"]) for p in row["parameters"]] == [("time", True)]
    elsewhere = ({**TRUTH[0], "joint": "B"},)
    assert score(found(DELAY), elsewhere)["joint_right"] is False
    outside = ({**TRUTH[0], "parameters": {"time": 0.02}},)
    assert [p["inside"] for p in score(found(DELAY), outside)["parameters"]] == [False]


@pytest.mark.parametrize(("truth", "known"), [((), True), (TRUTH, False)])
def test_where_nothing_known_is_hidden_a_name_is_wrong(truth, known):
    from _scoring import score

    assert score(found(GAIN), truth, known)["outcome"] == "wrong"
    assert score(found(), truth, known)["outcome"] == "right"


def test_the_matrix_has_a_line_for_every_label():
    from _scoring import matrix

    rows = [{"label": label, "seed": 1, "outcome": "right", "extra": []} for label in ("delay", "payload", "payload")]
    figure = matrix(rows)
    assert [text.get_text() for text in figure.axes[0].get_yticklabels()] == ["delay", "payload"]


def run(name, *options):
    """Run a study as a user does; warnings of a busy machine are none of its business."""
    done = subprocess.run(
        [sys.executable, f"{name}.py", *options], cwd=STUDIES, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return json.loads((STUDIES / "out" / name / "result.json").read_text(encoding="utf-8"))


@pytest.mark.slow
def test_blind_effects():
    result = run("blind_effects", "--arms", "1", "--cases", "2")
    assert result["cases"] == result["right"] == 2


@pytest.mark.slow
def test_real_pendulum():
    data = importlib.import_module("real_pendulum").DATA
    if not data.is_dir():
        pytest.skip("the recordings of the DFKI double pendulum are not at hand")
    result = run("real_pendulum")
    for row in result.values():
        for joint, part in row["corrected_below_published"].items():
            assert part >= row["retuned_below_published"][joint]


@pytest.mark.slow
def test_speed():
    result = run("speed")
    assert result["residual_and_jacobian_ms"] < 20.0
    assert result["retune_s"] < 2.0
    assert result["diagnosis_s"] < 60.0
    assert result["peak_mb"] < 1000.0
    assert result["retune_over_by_hand"] < 5.0  # some 2: slower than by hand, but not by much
