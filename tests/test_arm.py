"""The arm file: what is written reads back exactly; what is wrong is said in one line, with its key and value."""

import dataclasses
import math
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stribeck.arm import (
    Arm,
    EffectEntry,
    Friction,
    Joint,
    Tolerance,
    arm_to_toml,
    doubtful_values,
    load_arm,
    save_arm,
)
from stribeck.arm.file import MOST_RESOLUTION, TOLERATED
from stribeck.errors import InputError, StribeckError
from stribeck.textfile import load_toml

TEXT = """\
schema = "stribeck.arm/1"
name = "two links"
gravity = [9.81, 0]
sample_time = 0.002
[tolerance]
inertial = 0.05
[[joints]]
name = "A"
kind = "revolute"
length = 0.35
mass = 4.0
com = [0.17, 0.01]
inertia = 0.06
rotor_inertia = 0.15
torque_limit = 200.0
[joints.friction]
C0 = 4.6
C1 = 1.65
C2 = 1.4
alpha = 0.06
[joints.friction.backward]
C0 = 4.1
[[joints]]
name = "B"
kind = "revolute"
length = 0.2
mass = 1.0
com = [0.1, 0.0]
inertia = 0.01
rotor_inertia = 0.0
friction = { C0 = 1.0, C1 = 0.0, C2 = 0.1, alpha = 0.1 }
[[effects]]
effect = "presliding"
joints = ["A"]
parameters = { A = { stiffness = 1500.0, damping = 5 } }
[[effects]]
effect = "delay"
joints = ["A", "B"]
"""


def load_text(tmp_path: Path, text: str) -> Arm:
    path = tmp_path / "arm.toml"
    path.write_text(text, encoding="utf-8")
    return load_arm(path)


def test_contract_example_is_read(tmp_path: Path) -> None:
    arm = load_text(tmp_path, TEXT)
    assert (arm.n, arm.names, arm.gravity, arm.sample_time) == (2, ("A", "B"), (9.81, 0.0), 0.002)
    assert arm.tolerance == Tolerance(inertial=0.05, friction=1.0)
    first, second = arm.joints
    assert first.friction == Friction(4.6, 1.65, 1.4, 0.06)
    assert first.backward == Friction(4.1, 1.65, 1.4, 0.06)  # those left out equal the forward ones
    assert second.backward == second.friction == Friction(1.0, 0.0, 0.1, 0.1)
    assert (first.torque_limit, second.torque_limit, first.encoder_resolution) == (200.0, None, None)
    assert [entry.effect for entry in arm.effects] == ["presliding", "delay"]
    assert arm.effects[0].parameters == {"A": {"stiffness": 1500.0, "damping": 5.0}}
    assert arm.effects[1].parameters == {}


@pytest.mark.parametrize(
    ("old", "new", "key", "found"),
    [
        ("stribeck.arm/1", "stribeck.arm/2", "schema", "'stribeck.arm/2'"),
        ('schema = "stribeck.arm/1"', "", "schema is missing", ""),
        ("mass = 4.0", "mass = -4.0", "joints[0].mass", "-4.0"),
        ("mass = 1.0", "mass = 0", "joints[1].mass", "0"),
        ("mass = 4.0", "", "joints[0].mass is missing", ""),
        ("mass = 4.0", "mass = true", "joints[0].mass", "true"),
        ("mass = 4.0", 'mass = "4.0"', "joints[0].mass", '"4.0"'),
        ("mass = 4.0", "mass = inf", "joints[0].mass", "Infinity"),
        ("mass = 4.0", "mass = nan", "joints[0].mass", "NaN"),
        ("mass = 4.0", "mass = 1" + "0" * 400, "joints[0].mass", "1000"),
        ("inertia = 0.06", "inertia = -0.06", "joints[0].inertia", "-0.06"),
        ("rotor_inertia = 0.15", "rotor_inertia = -1", "joints[0].rotor_inertia", "-1"),
        ("length = 0.35", "length = -0.35", "joints[0].length", "-0.35"),
        ("C0 = 4.6", "C0 = -4.6", "joints[0].friction.C0", "-4.6"),
        ("C1 = 1.65", "C1 = -1.65", "joints[0].friction.C1", "-1.65"),
        ("C2 = 1.4", "C2 = -1.4", "joints[0].friction.C2", "-1.4"),
        ("alpha = 0.06", "alpha = 0.0", "joints[0].friction.alpha", "0.0"),
        ("C0 = 4.1", "C0 = -4.1", "joints[0].friction.backward.C0", "-4.1"),
        ("C0 = 4.1", "c0 = 4.1", "joints[0].friction.backward.c0", "did you mean 'C0'"),
        ("torque_limit", "torque_limt", "joints[0].torque_limt", "did you mean 'torque_limit'"),
        ('name = "two links"', 'name = "two links"\ngravty = 1', "gravty", "did you mean 'gravity'"),
        ("[tolerance]", "[tolerance]\nxyzzy = 1", "tolerance.xyzzy", "remove it"),
        (
            '[[joints]]\nname = "B"',
            '[joints.tolerance]\nc0 = 1.0\n[[joints]]\nname = "B"',
            "joints[0].tolerance.c0",
            "C0, C1",
        ),
        (
            '[[joints]]\nname = "B"',
            '[joints.tolerance]\nC0 = -1.0\n[[joints]]\nname = "B"',
            "joints[0].tolerance.C0",
            "-1",
        ),
        ("damping = 5", "damping = inf", "effects[0].parameters.A.damping", "Infinity"),
        ('joints = ["A"]', 'joints = ["C"]', "effects[0].joints[0]", "'C'"),
        ('joints = ["A", "B"]', 'joints = ["A", "A"]', "effects[1].joints", "A, A"),
        ('joints = ["A", "B"]', "joints = []", "effects[1].joints", "[]"),
        ("{ A = { stiff", "{ B = { stiff", "effects[0].parameters", "'B'"),
        ('name = "B"', 'name = "A"', "joints[1].name", "'A'"),
        ('name = "B"', 'name = ""', "joints[1].name", '""'),
        ('name = "B"', 'name = "B\\u0007"', "joints[1].name", "U+0007"),
        ('name = "two links"', 'name = "two\\uFFFElinks"', "name", "U+FFFE"),
        ("com = [0.17, 0.01]", "com = [0.17]", "joints[0].com[1] is missing", ""),
        ("com = [0.17, 0.01]", "com = [0.17, 0.01, 0.0]", "joints[0].com", "0.17"),
        ("gravity = [9.81, 0]", "gravity = 9.81", "gravity", "9.81"),
        ('kind = "revolute"', 'kind = "spherical"', "joints[0].kind", '"spherical"'),
        ('kind = "revolute"', 'kind = "prismatic"', "joints[0].kind", "2 joints"),
        ("[tolerance]", "[tolerance", "not valid TOML", "line 5"),
        ("sample_time = 0.002", "sample_time = 0", "sample_time", "0"),
        ("inertial = 0.05", "inertial = 0.0", "tolerance.inertial", "0.0"),
        ("inertial = 0.05", "inertial = 1e6", "tolerance.inertial must not be greater than 10", "1000000.0"),
        ("inertial = 0.05", "friction = 30", "tolerance.friction must not be greater than 10", "30"),
        ("com = [0.1, 0.0]\ninertia = 0.01", "com = [0, 0]\ninertia = 0", "joints[1] has no inertia", ""),
    ],
)
def test_wrong_value_names_its_key(tmp_path: Path, old: str, new: str, key: str, found: str) -> None:
    assert old in TEXT
    with pytest.raises(InputError) as caught:
        load_text(tmp_path, TEXT.replace(old, new, 1))
    line = str(caught.value)
    assert line.startswith(f"{tmp_path / 'arm.toml'}: {key}")
    assert found in line
    assert "\n" not in line
    assert len(line) < 400 + len(str(tmp_path))


def test_backward_directly_under_the_joint_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"joints\[0\]\.backward is not a known key"):
        load_text(tmp_path, TEXT.replace("[joints.friction.backward]", "[joints.backward]"))


@pytest.mark.parametrize("joints", ["joints = []", "joints = 3", "joints = [3]", ""])
def test_no_joints(tmp_path: Path, joints: str) -> None:
    with pytest.raises(InputError, match="joints"):
        load_text(tmp_path, f'schema = "stribeck.arm/1"\nname = "x"\ngravity = [0, 0]\n{joints}\n')


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"\x89PNG\r\n\x1a\n\0\0\xff", "UTF-8"),
        (b"#" * (1 << 20) + b"#", "1 MiB"),
        (b"x = " + b"[" * 100_000, "not valid"),
    ],
)
def test_files_that_are_no_arm(tmp_path: Path, content: bytes, says: str) -> None:
    path = tmp_path / "arm.toml"
    path.write_bytes(content)
    with pytest.raises(InputError, match=says):
        load_arm(path)


DOTS = "." * 120


@pytest.mark.parametrize(
    "text",
    [
        f"a = 1 # {DOTS}",
        f'a = "{DOTS}"',
        f"a = '{DOTS}'",
        f'a = "\\"{DOTS}"',
        f'a = """\n{DOTS}\n\\"""{DOTS}"""""',
        f"a = '''\n{DOTS}\n'{DOTS}'''''",
        f"'{DOTS}' = 1",
        f"a = '\\' # {DOTS}",
    ],
)
def test_dots_of_texts_and_comments_are_none_of_keys(tmp_path: Path, text: str) -> None:
    path = tmp_path / "any.toml"
    path.write_text(text)
    assert len(load_toml(path)) == 1
    deep = ".".join(["a"] * 120)
    path.write_text(f"{text}\nb = {{ c = 1, {deep} = 1 }}")
    with pytest.raises(InputError, match="a key of more than 100 names"):
        load_toml(path)


def test_unreadable_paths(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        load_arm(tmp_path / "missing.toml")
    with pytest.raises(InputError, match="is a directory"):
        load_arm(tmp_path)


def test_a_value_that_could_not_be_read_is_not_written(tmp_path: Path) -> None:
    arm = load_text(tmp_path, TEXT)
    broken = dataclasses.replace(arm, joints=(dataclasses.replace(arm.joints[0], mass=math.nan), arm.joints[1]))
    with pytest.raises(InputError, match="mass"):
        save_arm(broken, tmp_path / "new.toml")
    assert not (tmp_path / "new.toml").exists()


def test_written_file_states_units_and_keeps_numpy_scalars_plain(tmp_path: Path) -> None:
    arm = load_text(tmp_path, TEXT)
    text = arm_to_toml(dataclasses.replace(arm, sample_time=float(np.float64(0.1) * 3)))
    assert "mass = 4.0  # kg" in text
    assert "sample_time = 0.30000000000000004" in text
    assert "[joints.friction.backward]" in text
    assert text.count("backward") == 1  # the symmetric joint needs none
    assert "np." not in arm_to_toml(dataclasses.replace(arm, gravity=(np.float64(1.5), np.float64(0.0))))


def test_prismatic_axis_states_its_own_units(tmp_path: Path) -> None:
    text = arm_to_toml(Arm("axis", (0.0, 0.0), (prismatic(),)))
    assert "C2 = 0.5  # N s/m" in text
    (tmp_path / "arm.toml").write_text(text)
    assert load_arm(tmp_path / "arm.toml").joints == (prismatic(),)


def test_a_straight_axis_need_not_state_what_nothing_depends_on(tmp_path: Path) -> None:
    text = arm_to_toml(Arm("axis", (0.0, 0.0), (prismatic(),)))
    short = "\n".join(line for line in text.splitlines() if not line.startswith(("length", "com", "inertia =")))
    assert short.count("\n") == text.count("\n") - 4
    assert load_text(tmp_path, short).joints == (prismatic(),)
    with pytest.raises(InputError, match=r"joints\[0\]\.length is missing"):
        load_text(tmp_path, short.replace("prismatic", "revolute"))
    with pytest.raises(InputError, match=r"joints\[0\]\.mass is missing"):
        load_text(tmp_path, short.replace("mass", "# mass"))


def test_a_resolution_in_counts_is_refused_by_its_key(tmp_path: Path) -> None:
    arm = load_text(tmp_path, TEXT)
    first = dataclasses.replace(arm.joints[0], encoder_resolution=0.25)
    text = arm_to_toml(dataclasses.replace(arm, joints=(first, *arm.joints[1:])))
    says = r"joints\[0\]\.encoder_resolution must not be greater than 0.5 rad: found 16384; give the step in rad"
    with pytest.raises(InputError, match=says):
        load_text(tmp_path, text.replace("encoder_resolution = 0.25", "encoder_resolution = 16384"))


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"length": 350.0}, "length is 350 m: are these mm?"),
        ({"com": (200.0, 0.0)}, "com lies 200 m from its axis: are these mm?"),
        ({"com": (0.0, -1.7)}, "com lies 1.7 m from its axis, on a link of 0.35 m: check its decimal point"),
        ({"mass": 4000.0}, "mass is 4000 kg: are these grams?"),
        ({"encoder_resolution": 0.35}, "encoder_resolution is 0.35 rad: are these degrees?"),
        ({"com": (0.9, 0.0)}, None),  # a payload beyond the link
        ({"length": 0.0, "com": (1.5, 0.0)}, None),  # a last link whose length nobody asked for
        ({"kind": "prismatic", "com": (200.0, 0.0), "length": 350.0}, None),
    ],
)
def test_values_that_no_arm_has_are_doubted(tmp_path: Path, changes: dict[str, Any], says: str | None) -> None:
    joint = load_text(tmp_path, TEXT).joints[0]
    said = doubtful_values(Arm("x", (0.0, 0.0), (dataclasses.replace(joint, **changes),), 0.002))
    assert said == ([] if says is None else [f"A: the arm file's {says}"])


def test_a_sample_time_in_milliseconds_is_doubted(tmp_path: Path) -> None:
    arm = load_text(tmp_path, TEXT)
    assert doubtful_values(arm) == []
    slow = dataclasses.replace(arm, sample_time=2.0)
    assert doubtful_values(slow) == ["the arm file's sample_time is 2 s: are these milliseconds?"]


def prismatic() -> Joint:
    friction = Friction(1.0, 0.0, 0.5, 0.01)
    return Joint("x", "prismatic", 0.0, 2.0, (0.0, 0.0), 0.0, 0.0, friction, friction)


def test_error_text_is_one_bounded_line() -> None:
    error = StribeckError("a\nb", "c\x1b[31m" + "d" * 1000, "e\r\n f")
    assert str(error).startswith("a b: found c [31md")
    assert str(error).endswith("...; e f")
    assert str(error).isprintable()
    assert len(str(error)) < 200


finite = st.floats(allow_nan=False, allow_infinity=False)
positive = st.floats(min_value=0, exclude_min=True, allow_infinity=False)
relative = st.floats(min_value=0, exclude_min=True, max_value=10)
not_negative = st.floats(min_value=0, allow_infinity=False)
texts = st.text(st.characters(exclude_categories=["Cc", "Cn", "Cs"]), min_size=1, max_size=100)
frictions = st.builds(Friction, not_negative, not_negative, not_negative, positive)


@st.composite
def arms(draw: st.DrawFn) -> Arm:
    names = draw(st.lists(texts, min_size=1, max_size=4, unique=True))
    joints = [
        Joint(
            name=name,
            kind="revolute",
            length=draw(not_negative),
            mass=draw(positive),
            com=draw(st.tuples(finite, finite)),
            inertia=draw(positive),
            rotor_inertia=draw(not_negative),
            friction=(friction := draw(frictions)),
            backward=draw(st.sampled_from([friction, draw(frictions)])),
            torque_limit=draw(st.none() | positive),
            encoder_resolution=draw(st.none() | st.floats(0.0, MOST_RESOLUTION)),
            tolerance=draw(st.dictionaries(st.sampled_from(TOLERATED), not_negative, max_size=3)),
        )
        for name in names
    ]
    chosen = st.lists(st.sampled_from(names), min_size=1, unique=True).map(tuple)
    effects = []
    for _ in range(draw(st.integers(0, 3))):
        where = draw(chosen)
        values = st.dictionaries(st.sampled_from(where), st.dictionaries(texts, finite, max_size=3))
        effects.append(EffectEntry(draw(texts), where, draw(values), draw(st.none() | texts)))
    tolerance = Tolerance(draw(relative), draw(relative))
    sample_time = draw(st.none() | positive)
    return Arm(draw(texts), draw(st.tuples(finite, finite)), tuple(joints), sample_time, tolerance, tuple(effects))


@given(arm=arms())
def test_round_trip_is_exact(arm: Arm, tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.getbasetemp() / "round.toml"
    save_arm(arm, path)
    assert load_arm(path) == arm
    assert tomllib.loads(path.read_text("utf-8"))["schema"] == "stribeck.arm/1"
