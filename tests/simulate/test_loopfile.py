"""The loop file: read strictly, refused in one line."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stribeck.errors import InputError
from stribeck.run import Run, save_run
from stribeck.simulate import Compensation, Reference, load_loop, read_loop
from stribeck.simulate.foresight import without_foresight

from .conftest import entry, two_links

LOOP = """\
schema = "stribeck.loop/1"
sample_time = 0.0125        # s; 0 is a continuous controller
duration = 20.0             # s
[[joints]]
joint = "A"
kp = 60.0
kv = "critical"
ki = 0.0
velocity = "finite_difference"
velocity_filter = 0.0
delay_samples = 0
actuator_lag = 0.0
encoder_resolution = 0.0
encoder_noise = 0.0
[joints.compensation]
kind = "feedforward"
ratio = 1.0
at_zero = "zero"
dead_band = 0.0
[joints.reference]
kind = "ramp"
velocity = 0.05
initial_error = 0.0
"""


def test_reads_the_contract_s_example(tmp_path: Path) -> None:
    loop = load_loop(_write(tmp_path, LOOP), two_links())
    (joint,) = loop.joints
    assert (loop.sample_time, loop.duration, loop.seed) == (0.0125, 20.0, 0)
    assert (joint.joint, joint.kp, joint.kv, joint.ki) == ("A", 60.0, None, 0.0)
    assert joint.compensation == Compensation("feedforward")
    assert joint.reference == Reference("ramp", velocity=0.05)


def _write(folder: Path, text: str) -> Path:
    (folder / "loop.toml").write_text(text, encoding="utf-8")
    return folder / "loop.toml"


CONTINUOUS = ("sample_time = 0.0125", "sample_time = 0")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ([("kp = 60.0", "kp = 0.0")], "kp must be greater than 0"),
        ([("kp = 60.0", "kp = -60.0")], "joints[0].kp"),
        ([("kp = 60.0\n", "")], "kp is missing"),
        ([("kp = 60.0", "kq = 60.0")], "kq is not a known key; did you mean"),
        ([('kv = "critical"', "kv = -1.0")], "joints[0].kv must not be less than 0"),
        ([('kv = "critical"', 'kv = "cricital"')], "'critical'"),
        ([('kv = "critical"\n', "")], "kv is missing"),
        ([("ki = 0.0", "ki = nan")], "joints[0].ki"),
        ([("ki = 0.0", "ki = -1.0")], "joints[0].ki must not be less than 0"),
        ([("kp = 60.0", "kp = inf")], "joints[0].kp"),
        ([("kp = 60.0", "kp = true")], "joints[0].kp"),
        ([("velocity_filter = 0.0", "velocity_filter = -0.01")], "velocity_filter must not be less than 0"),
        ([("actuator_lag = 0.0", "actuator_lag = -0.01")], "actuator_lag must not be less than 0"),
        ([("encoder_resolution = 0.0", "encoder_resolution = -1e-6")], "encoder_resolution must not be less than 0"),
        ([("encoder_resolution = 0.0", "encoder_resolution = 1e-12")], "encoder_resolution is too fine"),
        ([("encoder_noise = 0.0", "encoder_noise = -1e-6")], "encoder_noise must not be less than 0"),
        ([("dead_band = 0.0", "dead_band = -0.1")], "dead_band must not be less than 0"),
        ([("sample_time = 0.0125", "sample_time = nan")], "sample_time"),
        ([CONTINUOUS, ("encoder_resolution = 0.0", "encoder_resolution = 1e-5")], "needs a sampled controller"),
        ([("kp = 60.0", "kp = 60.0\nstart = 1500.0")], "goes beyond 1000 rad"),
        ([('kind = "ramp"', 'kind = "regulate"'), ("initial_error = 0.0", "initial_error = 2e3")], "beyond 1000 rad"),
        ([('kind = "ramp"', 'kind = "sine"\namplitude = 5e3\nfrequency = 0.1')], "goes beyond 1000 rad"),
        ([('kind = "ramp"', 'kind = "sine"\namplitude = 900.0\nfrequency = 1.0')], "faster than 1000 rad/s"),
        ([('kind = "ramp"', 'kind = "steps"\ntimes = [0.0]\nvalues = [-4e3]')], "goes beyond 1000 rad"),
        ([('kind = "ramp"', 'kind = "steps"\ntimes = [0.0, 1.0]\nvalues = [0.0]')], "as many"),
        ([("velocity = 0.05", "velocity = inf")], "velocity"),
        ([("sample_time = 0.0125", "sample_time = -0.1")], "sample_time"),
        ([("duration = 20.0", "duration = 0.0")], "duration"),
        ([("duration = 20.0", "duration = 1e9")], "duration is more than"),
        ([("duration = 20.0", "duration = 0.001")], "duration is under two samples"),
        ([('joint = "A"', 'joint = "C"')], "is not a joint of this arm"),
        ([('kind = "ramp"', 'kind = "rump"')], "kind must be"),
        ([('kind = "feedforward"', 'kind = "magic"')], "kind must be"),
        ([("ratio = 1.0", "ratio = -1.0")], "ratio"),
        ([("delay_samples = 0", "delay_samples = 1.5")], "delay_samples must be a whole number"),
        ([("delay_samples = 0", "delay_samples = -1")], "delay_samples"),
        ([CONTINUOUS, ("delay_samples = 0", "delay_samples = 1")], "delay_samples needs a sampled controller"),
        ([CONTINUOUS, ("encoder_noise = 0.0", "encoder_noise = 1e-5")], "encoder_noise needs a sampled controller"),
        ([("velocity = 0.05", "velocity = 5e3")], "rad"),
        ([("velocity = 0.05", "velocity = 60.0")], "goes beyond 1000 rad"),
        ([('kind = "ramp"', 'kind = "sine"')], "frequency is missing"),
        ([('kind = "ramp"', 'kind = "file"')], "file is missing"),
        ([('kind = "ramp"', 'kind = "steps"')], "times and values must be as many"),
        ([('kind = "ramp"', 'kind = "steps"\ntimes = [1.0, 1.0]\nvalues = [0.0, 0.0]')], "times must increase"),
        ([('kind = "feedforward"', 'kind = "dither"')], "frequency is missing"),
        ([('"stribeck.loop/1"', '"stribeck.loop/2"')], "schema"),
        ([("duration = 20.0", 'duration = 20.0\nclamp = { A = 0.1 }')], "clamp"),
        ([("duration = 20.0", 'duration = 20.0\nclamp = { B = -1500.0 }')], "clamp.B lies beyond 1000 rad: found"),
    ],
)  # fmt: skip
def test_refuses_in_one_line(changes: list[tuple[str, str]], words: str, tmp_path: Path) -> None:
    text = LOOP
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    with pytest.raises(InputError) as caught:
        load_loop(_write(tmp_path, text), two_links())
    message = str(caught.value)
    assert words in message
    assert "loop.toml" in message
    assert "\n" not in message


def test_a_joint_twice(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="controlled twice"):
        load_loop(_write(tmp_path, LOOP + LOOP[LOOP.index("[[joints]]") :]), two_links())


@pytest.mark.parametrize("effect", ["delay", "time_shift"])
def test_continuous_control_of_a_late_arm(tmp_path: Path, effect: str) -> None:
    """A position that is read late is as late to the controller as a command that is."""
    arm = two_links(entry(effect, ("A",), time=0.01))
    with pytest.raises(InputError, match=f"effect {effect}"):
        load_loop(_write(tmp_path, LOOP.replace(*CONTINUOUS)), arm)
    load_loop(_write(tmp_path, LOOP), arm)


def test_an_arm_that_looks_ahead(tmp_path: Path) -> None:
    arm = two_links(entry("time_shift", ("B",), time=-0.01))
    with pytest.raises(InputError, match=r"time_shift at B looks ahead in time: found -0\.01 s"):
        load_loop(_write(tmp_path, LOOP), arm)


def test_a_followed_file(tmp_path: Path) -> None:
    t = 0.01 * np.arange(100)
    save_run(Run("move.csv", t, np.stack([0.2 * t, 0 * t], axis=1), np.zeros((100, 2))), tmp_path / "move.csv")
    loop = load_loop(_write(tmp_path, LOOP.replace('kind = "ramp"', 'kind = "file"\nfile = "move.csv"')), two_links())
    assert loop.joints[0].reference.values[:2] == (0.0, 0.002)
    with pytest.raises(InputError, match=r"missing\.csv"):
        load_loop(_write(tmp_path, LOOP.replace('kind = "ramp"', 'kind = "file"\nfile = "missing.csv"')), two_links())


@pytest.mark.parametrize("column", ["q", "q_ref"])
def test_a_followed_file_is_mended_as_any_run_is(tmp_path: Path, column: str) -> None:
    """A counter that begins its turn anew, and one wrong reading, are no leaps to follow."""
    t = 0.01 * np.arange(400)
    way = np.stack([2.0 * t + 0.1 * np.sin(3.0 * t), 0 * t], axis=1)
    q = (way + np.pi) % (2.0 * np.pi) - np.pi
    given = replace(Run("move.csv", t, q, 0 * q), q_ref=q if column == "q_ref" else None)
    given.q[300, 0] += 0.7 if column == "q" else 0.0
    save_run(given, tmp_path / "move.csv")
    loop, notes, warnings = read_loop(
        _write(tmp_path, LOOP.replace('kind = "ramp"', 'kind = "file"\nfile = "move.csv"')), two_links()
    )
    assert loop.joints[0].reference.values == pytest.approx(way[:, 0], abs=1e-3)
    assert notes[0] == "move.csv: leaps by a turn, as of a counter that begins anew: q1 (1 times)"
    assert len(notes) == (2 if column == "q" else 1)
    assert warnings == ()


def test_a_followed_file_in_degrees_is_doubted(tmp_path: Path) -> None:
    t = 0.01 * np.arange(100)
    save_run(Run("move.csv", t, np.stack([40.0 * t, 0 * t], axis=1), np.zeros((100, 2))), tmp_path / "move.csv")
    file = _write(tmp_path, LOOP.replace('kind = "ramp"', 'kind = "file"\nfile = "move.csv"'))
    assert read_loop(file, two_links())[1:] == ((), ("move.csv: q1 reaches 39.6 rad: are these degrees?",))


def test_a_straight_axis_is_told_in_metres(tmp_path: Path) -> None:
    arm = two_links()
    straight = replace(arm, joints=tuple(replace(joint, kind="prismatic") for joint in arm.joints))
    for old, new, words in [
        ("velocity = 0.05", "velocity = 60.0", "goes beyond 1000 m: found 1200; give it in m, and"),
        ("velocity = 0.05", "velocity = 5e3\n", "goes beyond 1000 m"),
        ('kind = "ramp"', 'kind = "sine"\namplitude = 900.0\nfrequency = 1.0', "faster than 1000 m/s"),
        ("duration = 20.0", "duration = 20.0\nclamp = { B = -1500.0 }", "clamp.B lies beyond 1000 m: found"),
    ]:
        with pytest.raises(InputError, match=words):
            load_loop(_write(tmp_path, LOOP.replace(old, new)), straight)


def test_an_arm_that_looks_ahead_by_as_little_as_any_is_simulated_without() -> None:
    """Re-tuning takes such lateness in, of either sign: what a diagnosis delivers is to be used."""
    kept = replace(entry("actuator_lag", ("A",), time_constant=0.02), law="one_pole")
    arm = two_links(entry("time_shift", ("A", "B"), time=-0.0003), kept)
    prompt, (first, second) = without_foresight(arm)
    assert prompt.effects == (kept,)
    assert first.startswith("A: a record that is 0.3 ms early is left out here")
    assert second.startswith("B:")
    for other in (two_links(kept), two_links(entry("time_shift", ("B",), time=-0.01))):
        assert without_foresight(other) == (other, [])
