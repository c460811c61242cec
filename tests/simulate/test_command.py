"""``stribeck simulate``: its files, and its failures."""

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
import pytest

from stribeck.arm import Arm, save_arm
from stribeck.cli import main
from stribeck.report.simulation import motion_figure
from stribeck.report.style import finding_of
from stribeck.run import load_run
from stribeck.simulate import Compensation, JointLoop, Loop, Reference, simulate_loop
from stribeck.simulate.metrics import measures, simulation_json, stopped, told

from .conftest import entry, two_links

LOOP = """\
schema = "stribeck.loop/1"
sample_time = 0.0125
duration = 20.0
[[joints]]
joint = "A"
kp = 60.0
kv = "critical"
[joints.reference]
kind = "ramp"
velocity = 0.05
"""


@pytest.fixture
def bench(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    save_arm(two_links(), "arm.toml")
    Path("loop.toml").write_text(LOOP)
    return tmp_path


@pytest.mark.usefixtures("bench")
def test_writes_a_run_and_its_measures(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", "arm.toml", "loop.toml", "--out", "out"]) == 0
    said = capsys.readouterr()
    assert said.err == ""
    found = json.loads(Path("out/simulation.json").read_text())
    run = load_run("out/simulation.csv", 2)
    assert found["schema"] == "stribeck.simulation/1"
    assert list(found["joints"]) == ["A"]
    error = run.q_ref[:, 0] - run.q[:, 0]
    late = error[len(error) // 2 :]
    half = found["joints"]["A"]
    assert half["mean_error"] == pytest.approx(late.mean(), rel=1e-9)
    assert half["rms_error"] == pytest.approx(np.sqrt(np.mean(late**2)), rel=1e-9)
    assert half["peak_error"] == pytest.approx(np.abs(late).max(), rel=1e-9)
    assert half["whole"]["peak_torque"] == pytest.approx(np.abs(run.tau[:, 0]).max(), rel=1e-9)
    assert half["whole"]["peak_velocity"] > half["peak_velocity"] > 0.049
    assert half["mean_error"] == pytest.approx((5 + 1.25 * np.exp(-1) + 1.5 * 0.05) / 60.0, rel=1e-6)
    assert 0.0 < half["whole"]["stick_fraction"] < 0.5
    assert found["units"]["mean_error"] == "rad"
    error = f"rms error over the second half: {half['rms_error']:.3g} rad at A"
    assert said.out.splitlines() == [
        f"20 s simulated, 1 event; {error}",
        "out: simulation.csv, simulation.json and motion_*.png",
    ]
    assert (run.q[:, 1] == 0.0).all()
    assert Path("out/motion_1.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.usefixtures("bench")
def test_a_prismatic_axis_is_in_metres() -> None:
    joint = replace(two_links().joints[0], kind="prismatic", com=(0.0, 0.0), inertia=0.0)
    save_arm(Arm("axis", (0.0, 0.0), (joint,)), "arm.toml")
    assert main(["simulate", "arm.toml", "loop.toml", "--out", "out"]) == 0
    units = json.loads(Path("out/simulation.json").read_text())["units"]
    assert [units[name] for name in ("mean_error", "peak_velocity", "peak_torque", "ended")] == ["m", "m/s", "N", "s"]


@pytest.mark.usefixtures("bench")
def test_an_unstable_loop_says_when(capsys: pytest.CaptureFixture[str]) -> None:
    Path("loop.toml").write_text(LOOP.replace("kp = 60.0", "kp = 90000.0"))
    assert main(["simulate", "arm.toml", "loop.toml", "--out", "out"]) == 0
    found = json.loads(Path("out/simulation.json").read_text())
    assert found["status"] == "unbounded"
    assert 0.0 < found["ended"] < 20.0
    said = capsys.readouterr()
    assert said.err == f"warning: unbounded after {found['ended']:.6g} s\n"
    assert "second half" not in said.out
    late = found["joints"]["A"]
    assert {late[name] for name in late if name != "whole"} == {None}
    assert late["whole"]["peak_error"] > 0.0


def test_measures_are_of_what_was_reached_of_the_second_half() -> None:
    whole = simulate_loop(two_links(), Loop(0.0125, 1.0, (JointLoop("A", 60.0, Reference("ramp", velocity=0.05)),)))
    short = replace(whole, motion=replace(whole.motion, status="unbounded", filled=60), ended=0.75)
    expected = np.sqrt(np.mean(whole.error[40:60, 0] ** 2))
    assert measures(short, 0, 40)["rms_error"] == expected
    assert simulation_json(short, two_links(), Loop(0.0125, 1.0, ()))["joints"]["A"]["rms_error"] == expected
    assert told(short, two_links()).endswith(f"what was reached of the second half: {expected:.3g} rad at A")


@pytest.mark.parametrize("kind", ["robust", "none"])
def test_a_law_that_switches_without_end_is_told(kind: Literal["robust", "none"]) -> None:
    ramp = JointLoop("A", 60.0, Reference("ramp", velocity=0.05), compensation=Compensation(kind, 1.1))
    loop = Loop(0.0, 0.1, (ramp,))
    whole = simulate_loop(two_links(), loop)
    assert stopped(whole, loop) == []
    (line,) = stopped(replace(whole, motion=replace(whole.motion, status="too_many_steps"), ended=0.05), loop)
    assert line.startswith("too_many_steps after 0.05 s")
    assert ("jumps, at A, and may switch without end; give a sample_time" in line) == (kind == "robust")


@pytest.mark.usefixtures("bench")
def test_a_command_at_its_limit_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    arm = two_links()
    save_arm(replace(arm, joints=(replace(arm.joints[0], torque_limit=40.0), *arm.joints[1:])), "arm.toml")
    Path("loop.toml").write_text(LOOP.replace("kp = 60.0", "kp = 90000.0").replace("20.0", "2.0"))
    assert main(["simulate", "arm.toml", "loop.toml", "--out", "out"]) == 0
    assert json.loads(Path("out/simulation.json").read_text())["status"] == "ok"
    (line,) = capsys.readouterr().err.splitlines()
    found = re.fullmatch(r"warning: A: the command is at its limit for ([\d.]+) % of the time", line)
    tau = load_run("out/simulation.csv", 2).tau[:, 0]
    assert found is not None
    assert float(found[1]) == pytest.approx(100.0 * np.mean(np.abs(tau) == 40.0), abs=0.1)


@pytest.mark.parametrize(
    ("kind", "label", "unit"), [("revolute", "torque, N m", "mrad"), ("prismatic", "force, N", "mm")]
)
def test_the_figure_is_in_the_joints_own_words(kind: Literal["revolute", "prismatic"], label: str, unit: str) -> None:
    """The error swings about nought: its mean says nothing of its size."""
    joint = replace(two_links().joints[0], kind=kind, com=(0.0, 0.0), inertia=0.0)
    arm = Arm("one", (0.0, 0.0), (joint,))
    sine = JointLoop("A", 60.0, Reference("sine", amplitude=0.5, frequency=0.5))
    closed = simulate_loop(arm, Loop(0.0125, 8.0, (sine,)))
    figure = motion_figure(closed, arm, 0)
    late = closed.error[closed.motion.filled // 2 :, 0]
    assert f"rms error {1e3 * np.sqrt(np.mean(late**2)):.4g} {unit} in the second half" in finding_of(figure)
    assert figure.axes[2].get_ylabel() == label


def test_a_signal_that_stands_still_is_a_line_in_a_range_of_its_own() -> None:
    still = simulate_loop(two_links(), Loop(0.0125, 1.0, (JointLoop("B", 60.0, Reference("regulate")),)))
    figure = motion_figure(still, two_links(), 1)
    assert [ax.get_ylim() for ax in figure.axes] == [(-1.0, 1.0)] * 3


@pytest.mark.usefixtures("bench")
def test_what_records_alone_show_is_told_to_be_left_out(capsys: pytest.CaptureFixture[str]) -> None:
    save_arm(two_links(entry("velocity_filter", ("B",), time=0.03)), "arm.toml")
    assert main(["simulate", "arm.toml", "loop.toml", "--out", "out"]) == 0
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("warning: B: velocity_filter is of records alone and left out here")


@pytest.mark.usefixtures("bench")
def test_an_arm_whose_decay_is_zero(capsys: pytest.CaptureFixture[str]) -> None:
    text = Path("arm.toml").read_text()
    Path("arm.toml").write_text(text.replace("alpha = 0.05", "alpha = 0.0", 1))
    assert main(["simulate", "arm.toml", "loop.toml", "--out", "out"]) == 2
    error = capsys.readouterr().err
    assert "arm.toml: joints[0].friction.alpha must be greater than 0" in error
    assert error.count("\n") == 1
    assert not Path("out").exists()


@pytest.mark.usefixtures("bench")
@pytest.mark.parametrize(("old", "new"), [("kp = 60.0", "kp = -60.0"), ('"A"', '"C"'), ("[[joints]]", "[joints]")])
def test_wrong_input_is_one_line_and_no_folder(old: str, new: str, capsys: pytest.CaptureFixture[str]) -> None:
    Path("loop.toml").write_text(LOOP.replace(old, new, 1))
    assert main(["simulate", "arm.toml", "loop.toml", "--out", "out"]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert not Path("out").exists()
