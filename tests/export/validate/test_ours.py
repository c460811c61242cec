"""An arm's own FMU: no problems as it is exported, and every change to it is noticed."""

import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import fmpy
import numpy as np
import pytest

from stribeck.arm import Arm, EffectEntry, Friction, Joint, arm_to_toml
from stribeck.export import export_fmu
from stribeck.export.validate import check_fmu, validate_fmu
from stribeck.export.validate.check import Validation
from stribeck.export.validate.compare import Deviation, against_simulator, trial_command
from stribeck.export.validate.opened import Opened, opened
from stribeck.export.validate.told import told
from stribeck.simulate import Engine, path_of

from ..conftest import two_links

FRICTION = Friction(5.0, 1.25, 1.5, 0.05)


def one_joint(*effects: EffectEntry, mass: float = 1.0, kind: str = "revolute") -> Arm:
    joint = Joint("A", kind, 0.3, mass, (0.1, 0.0), 0.5, 0.5, FRICTION, FRICTION)  # type: ignore[arg-type]
    return Arm("one joint", (0.0, 0.0), (joint,), effects=tuple(effects))


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("fmu") / "one.fmu"
    export_fmu(one_joint(), path, fmi=2, platforms=["x86_64-linux"])
    return path


def changed(fmu: Path, out: Path, changes: dict[str, Callable[[bytes], bytes]]) -> Path:
    """A copy with some files changed."""
    with zipfile.ZipFile(fmu) as source, zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as target:
        for name in source.namelist():
            data = source.read(name)
            target.writestr(name, changes[name](data) if name in changes else data)
    return out


def swap(old: str, new: str) -> Callable[[bytes], bytes]:
    def change(data: bytes) -> bytes:
        assert old.encode() in data, old
        return data.replace(old.encode(), new.encode())

    return change


def test_no_problems_and_a_deviation_in_numbers(exported: Path) -> None:
    found = check_fmu(exported)
    assert found.problems == ()
    assert {one.kind for one in found.deviations} == {"CoSimulation", "ModelExchange"}
    for one in found.deviations:
        assert 0.0 < one.position < {"CoSimulation": 1e-8, "ModelExchange": 1e-6}[one.kind]
        assert one.events >= 4


BIG = "".join(
    f"""[[joints]]
name = "{i}"
kind = "revolute"
length = 0.1
mass = 1.0
com = [0.0, 0.0]
inertia = 1.0
rotor_inertia = 0.0
friction = {{ C0 = 0.0, C1 = 0.0, C2 = 0.0, alpha = 1.0 }}
"""
    for i in range(40)
)  # an arm whose modes nobody could search

CHANGES: dict[str, tuple[str, Callable[[bytes], bytes], str]] = {
    "mass": (
        "resources/arm.toml",
        swap("mass = 1.0", "mass = 1.5"),
        "variable joint[1].mass starts at 1.0; 1.5 stands",
    ),
    "friction": ("resources/arm.toml", swap("C0 = 5.0", "C0 = 6.0"), "departs from the arm's own simulator by"),
    "name": ("modelDescription.xml", swap('name="q[1]"', 'name="angle[1]"'), "variable q[1] is missing"),
    "causality": ("modelDescription.xml", swap('name="tau_friction[1]"', 'name="x[1]"'), "tau_friction[1] is missing"),
    "unit": (
        "modelDescription.xml",
        swap('<BaseUnit kg="1" m="2" s="-2"/>', '<BaseUnit kg="1" m="2" s="-1"/>'),
        "unit",
    ),
    "start": (
        "modelDescription.xml",
        swap('start="0.05"', 'start="0.06"'),
        "friction.alpha starts at 0.06; 0.05 stands",
    ),
    "token": ("modelDescription.xml", swap('guid="{', 'guid="{0'), "Failed to instantiate"),
    "source": ("sources/step.h", swap("static", "statik"), "the sources do not build: sources/"),
    "document": ("documentation/index.html", swap("one joint", "another"), "index.html differs from what this version"),
    "another arm": ("resources/arm.toml", swap("[[joints]]", BIG + "[[joints]]"), "variable tau[41] is missing"),
    "arm file": ("resources/arm.toml", swap("mass = 1.0", "mass = -1.0"), "joints[0].mass must be greater than 0"),
}


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.long) if name == "source" else name for name in CHANGES]
)
def test_change_is_noticed(exported: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    file, change, says = CHANGES[name]
    runs = name in ("friction", "token", "another arm", "source")
    if name != "document":  # an export takes seconds, and so does a build
        monkeypatch.setattr("stribeck.export.validate.check.reproduction", lambda fmu, arm: ([], ["not looked at"]))
    if name != "source":
        monkeypatch.setattr("stribeck.export.validate.check.build_sources", lambda fmu, target: ([], []))
    else:  # it is the build that shows it
        monkeypatch.setattr("stribeck.export.validate.check._run", lambda *given: [])
    if name == "another arm":  # all that matters is that it is not compared with a simulator
        monkeypatch.setattr("stribeck.export.validate.check.by_itself", lambda fmu, kind, library: [])
    problems = validate_fmu(changed(exported, tmp_path / "changed.fmu", {file: change}), run=runs)
    assert any(says in problem for problem in problems), problems


def test_what_an_export_leaves_out_is_not_missed(
    exported: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Effects of records alone, and those at their null values."""
    left = one_joint(
        EffectEntry("velocity_filter", ("A",), {"A": {"time": 0.02}}),
        EffectEntry("torque_gain", ("A",), {"A": {"gain": 1.0}}),
        EffectEntry("delay", ("A",), {"A": {"time": 0.0}}),
    )
    monkeypatch.setattr("stribeck.export.validate.check.reproduction", lambda fmu, arm: ([], []))
    change = {"resources/arm.toml": lambda _: arm_to_toml(left).encode()}
    assert check_fmu(changed(exported, tmp_path / "left.fmu", change)).problems == ()
    there = one_joint(EffectEntry("torque_gain", ("A",), {"A": {"gain": 0.9}}))
    change = {"resources/arm.toml": lambda _: arm_to_toml(there).encode()}
    problems = check_fmu(changed(exported, tmp_path / "there.fmu", change), run=False).problems
    assert problems == ("variable effect.torque_gain[1].gain is missing",)


def test_without_a_binary_for_this_machine_its_sources_are_run(
    exported: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Even where they are those of this version, as an export for other platforms has them."""
    own = f"binaries/{fmpy.platform}/"
    with zipfile.ZipFile(exported) as source, zipfile.ZipFile(tmp_path / "other.fmu", "w") as target:
        for name in source.namelist():
            if not name.startswith(own):
                target.writestr(name, source.read(name))
        (binary,) = (source.read(name) for name in source.namelist() if name.startswith(own))

    def build_sources(fmu: Opened, target: Path) -> tuple[list[str], list[str]]:
        target.write_bytes(binary)
        return [], []

    monkeypatch.setattr("stribeck.export.validate.check.reproduction", lambda fmu, arm: ([], []))
    monkeypatch.setattr("stribeck.export.validate.check.build_sources", build_sources)
    found = check_fmu(tmp_path / "other.fmu")
    assert found.problems == ()
    assert {one.kind for one in found.deviations} == {"CoSimulation", "ModelExchange"}


def test_an_effect_that_is_not_installed_is_told_once(
    exported: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("stribeck.export.validate.check.build_sources", lambda fmu, target: ([], []))
    effect = swap("[[joints]]", '[[effects]]\neffect = "my_drive"\njoints = ["A"]\n[[joints]]')
    found = check_fmu(changed(exported, tmp_path / "changed.fmu", {"resources/arm.toml": effect}), run=False)
    assert [text for text in found.problems if "my_drive" in text] == [
        "resources/arm.toml has the effect my_drive, which is not installed here: the arm is left out of account"
    ]
    assert not any("use one of" in text for text in (*found.problems, *found.skipped))
    assert len(found.problems) == 1


@pytest.mark.long
def test_a_straight_axis_is_compared_in_metres(made: Callable[[Arm, int], Path]) -> None:
    arm = one_joint(kind="prismatic")
    with opened(made(arm, 2)) as fmu:
        found = against_simulator(fmu, arm, "CoSimulation")
    said = told(Validation((), (), (found,), ()))
    assert said[0].startswith(f"CoSimulation: at most {found.position:.2g} m from the arm's own simulator")


def test_an_axis_that_hangs_sticks_in_its_trial() -> None:
    arm = replace(one_joint(mass=20.0, kind="prismatic"), gravity=(-9.81, 0.0))
    engine = Engine(path_of(arm))
    times, command = trial_command(engine)
    assert command[0] == pytest.approx(20.0 * 9.81)
    motion = engine.run(engine.p, engine.start(engine.p, np.zeros(1), command=command[0]), times, command)
    assert motion.event_count >= 3


def test_a_motion_without_stiction_is_said_to_be_one(exported: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("stribeck.export.validate.check.reproduction", lambda fmu, arm: ([], []))
    told = "stiction: no joint stuck or broke away in the motion that was compared"
    for events in (0, 3):
        seen = Deviation("CoSimulation", 0.0, events, 1e-8)
        monkeypatch.setattr("stribeck.export.validate.check.against_simulator", lambda *given, seen=seen: seen)
        assert (told in check_fmu(exported).skipped) == (events == 0)


@pytest.mark.slow
@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("name", ["presliding", "joint_flexibility", "delay", "prismatic"])
def test_effects_and_kinds(tmp_path: Path, name: str, fmi: int) -> None:
    values = {
        "presliding": {"stiffness": 1500.0, "damping": 5.0},
        "joint_flexibility": {"stiffness": 5000.0, "damping": 2.0},
        "delay": {"time": 0.007},
    }
    arm = (
        one_joint(kind="prismatic")
        if name == "prismatic"
        else one_joint(EffectEntry(name, ("A",), {"A": values[name]}))
    )
    export_fmu(arm, tmp_path / "one.fmu", fmi=fmi, platforms=["x86_64-linux"])
    found = check_fmu(tmp_path / "one.fmu")
    assert found.problems == ()
    assert len(found.deviations) == (1 if name == "delay" else 2)


def test_carries_the_arm_exactly(exported: Path) -> None:
    with zipfile.ZipFile(exported) as archive:
        assert archive.read("resources/arm.toml").decode() == arm_to_toml(one_joint())


@pytest.mark.long
def test_what_remembers_the_torque_starts_alike(made: Callable[[Arm, int], Path]) -> None:
    """The second joint's trial torque is not zero at the start: its lag settles there in the FMU and the simulator."""
    arm = two_links(EffectEntry("actuator_lag", ("B",), {"B": {"time_constant": 0.004}}))
    with opened(made(arm, 2)) as fmu:
        assert against_simulator(fmu, arm, "CoSimulation").position < 1e-8


@pytest.mark.long
def test_an_arm_that_magnifies_errors_is_allowed_its_own(made: Callable[[Arm, int], Path]) -> None:
    """Play in joint A: at the usual tolerance the simulator is off by over 1e-8 rad, and so is the FMU."""
    play = EffectEntry("backlash", ("A",), {"A": {"gap": 0.01, "stiffness": 3000.0, "damping": 3.0}})
    arm = two_links(play, gravity=(9.81, 0.0))
    with opened(made(arm, 2)) as fmu:
        found = against_simulator(fmu, arm, "CoSimulation")
        assert 1e-8 < found.position < found.allowed < 1e-7
        other = replace(play, parameters={"A": {**play.parameters["A"], "damping": 3.001}})
        wrong = against_simulator(fmu, replace(arm, effects=(other,)), "CoSimulation")
        assert wrong.position > 10.0 * wrong.allowed


@pytest.mark.slow
def test_the_importers_own_error_along_a_long_chain_is_no_defect(made: Callable[[Arm, int], Path]) -> None:
    light = Friction(0.5, 0.2, 0.1, 0.05)
    links = [Joint(f"J{k}", "revolute", 0.3, 1.0, (0.15, 0.0), 0.01, 0.01, light, light) for k in range(3)]
    links[1] = replace(links[1], com=(0.1, -0.05))
    arm = Arm("chain", (-3.0, 9.0), (*links, replace(links[0], name="J3", mass=0.2, inertia=0.001)))
    with opened(made(arm, 2)) as fmu:
        found = against_simulator(fmu, arm, "ModelExchange")
        assert found.position < found.allowed
        heavier = replace(arm, joints=(*arm.joints[:3], replace(arm.joints[3], mass=arm.joints[3].mass * 1.0001)))
        wrong = against_simulator(fmu, heavier, "ModelExchange")
        assert wrong.position > wrong.allowed
