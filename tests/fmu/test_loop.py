"""The paper's experiment as a loop of FMUs, against the loop inside the engine."""

import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.ssp.simulation import simulate_ssp

from stribeck.arm import Arm, EffectEntry, Friction, Joint, load_arm, save_arm
from stribeck.cli import main
from stribeck.errors import InputError, StribeckError
from stribeck.export import export_fmu
from stribeck.export.controller import export_controller, export_system
from stribeck.export.controller.export import describe
from stribeck.export.use import load_fmu_loop, simulate_fmu
from stribeck.export.use.plant import FmuPlant, fmu_plant
from stribeck.export.validate import check_fmu
from stribeck.export.validate.opened import ARM, opened
from stribeck.run import load_run
from stribeck.simulate import Compensation, JointLoop, Loop, Reference, simulate_loop

from ..export.validate.test_ours import changed, swap
from .conftest import HERE, MODELS
from .master import slave
from .test_folders import table

# what is of the command and of the loop does not hang on the version; what is of the FMU is tested in both
ONE_VERSION = pytest.mark.parametrize("fmi", [2, pytest.param(3, marks=pytest.mark.slow)], indirect=True)


@pytest.mark.long
def test_loop_around_the_fmu_is_the_loop_around_the_engine(arm_fmu: Path, arm: Arm, loop: Loop) -> None:
    expected = table(MODELS / "two_link_nominal" / "loop_reference.csv")
    found = simulate_fmu(arm_fmu, arm, loop)
    assert found.motion.ok
    for k in range(arm.n):
        np.testing.assert_allclose(found.measured[:, k], expected[f"q{k + 1}"], rtol=0.0, atol=1e-8)
        np.testing.assert_allclose(found.command[:, k], expected[f"tau{k + 1}"], rtol=0.0, atol=1e-5)
    assert np.abs(found.measured[-1, 0]) > 0.1
    stuck = simulate_loop(arm, loop).motion.stuck_time[-1]
    np.testing.assert_allclose(found.motion.stuck_time[-1], stuck, rtol=0.0, atol=3 * loop.sample_time)


def test_steps_of_a_sample_are_as_many_as_a_delay_takes(arm: Arm, arm_fmu: Path) -> None:
    late = replace(arm, effects=(EffectEntry("delay", ("A",), {"A": {"time": 0.2}}),))
    with opened(arm_fmu) as fmu:
        assert FmuPlant(fmu, arm.n).most_steps(1e-3) == 2048
        save_arm(late, fmu.folder / ARM)
        assert FmuPlant(fmu, arm.n).most_steps(1e-3) == 20
        assert FmuPlant(fmu, arm.n).most_steps(1e-5) == 1
        (fmu.folder / ARM).write_text("of another version")
        assert FmuPlant(fmu, arm.n).most_steps(1e-3) == 2048


@pytest.mark.slow
def test_a_long_delay_and_a_short_lag_go_together(arm: Arm, tmp_path: Path) -> None:
    """What is on its way to a late arm must not be more than the FMU keeps."""
    late = replace(arm, effects=(EffectEntry("delay", ("A",), {"A": {"time": 0.2}}),))
    export_fmu(late, tmp_path / "late.fmu", platforms=HERE)
    entry = JointLoop("A", 60.0, Reference("regulate", initial_error=0.3), kv=5.0, actuator_lag=2e-4)
    loop = Loop(1e-3, 0.4, (entry, replace(entry, joint="B", kp=20.0, actuator_lag=1e-3)))
    found = simulate_fmu(tmp_path / "late.fmu", late, loop)
    assert (found.motion.status, found.ended) == ("ok", 0.4)
    np.testing.assert_allclose(found.measured, simulate_loop(late, loop).measured, rtol=0.0, atol=1e-5)


class Failing:
    """An FMU's instance that will not terminate, and some of whose values are no numbers."""

    def __init__(self, inner: Any, mad: set[int]) -> None:
        self.inner, self.mad, self.freed = inner, mad, False

    def __getattr__(self, name: str) -> Any:
        return getattr(self.inner, name)

    def getReal(self, numbers: list[int]) -> list[float]:
        return [
            np.nan if n in self.mad else value for n, value in zip(numbers, self.inner.getReal(numbers), strict=True)
        ]

    def getFloat64(self, numbers: list[int]) -> list[float]:
        return [np.nan if n in self.mad else x for n, x in zip(numbers, self.inner.getFloat64(numbers), strict=True)]

    def terminate(self) -> None:
        raise RuntimeError("no")

    def freeInstance(self) -> None:
        self.freed = True
        self.inner.terminate()
        self.inner.freeInstance()


@pytest.mark.parametrize(("shown", "what"), [("q", "position"), ("dq", "velocity")])
def test_what_an_fmu_gives_must_be_numbers_and_its_failure_is_the_last_word(
    arm_fmu: Path, arm: Arm, shown: str, what: str
) -> None:
    with fmu_plant(arm_fmu, arm.n) as plant:
        plant.start(np.zeros(arm.n))
        broken = plant._instance = Failing(plant._instance, {plant._numbers[f"{shown}[1]"]})
        with pytest.raises(StribeckError, match=f"gives a {what} that is not finite"):
            plant.step(0.0, 1e-3, np.zeros(arm.n))
        plant.close()
        assert broken.freed
        assert plant._instance is None


def test_controller_first_then_the_arm_loses_no_time(arm_fmu: Path, controller_fmu: Path, loop: Loop) -> None:
    expected = table(MODELS / "two_link_nominal" / "loop_reference.csv")
    step, worst = loop.sample_time, 0.0
    with slave(controller_fmu) as controller, slave(arm_fmu) as plant:
        controller.begin()
        plant.begin()
        for i in range(len(expected) - 1):
            controller.set("q", plant.get("q", 2))
            controller.step(i * step, step)
            plant.set("tau", controller.get("tau", 2))
            plant.step(i * step, step)
            now = plant.get("q", 2)
            worst = max(worst, *(abs(now[k] - expected[f"q{k + 1}"][i + 1]) for k in range(2)))
    assert worst < 1e-8


def test_controller_is_a_sound_fmu(controller_fmu: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("stribeck.export.validate.check.build_sources", lambda fmu, target: ([], []))  # takes seconds
    assert check_fmu(controller_fmu).problems == ()


def test_units_of_a_controller() -> None:
    """As d theta/dt = gain (Y (de/dt + slope e) - leakage theta) has them, and a reference of its kind."""
    friction = Friction(4.0, 1.0, 2.0, 0.01)
    units = {}
    for kind in ("revolute", "prismatic"):
        arm = Arm("one", (0.0, 0.0), (Joint("X", kind, 0.3, 3.0, (0.0, 0.0), 0.0, 1.0, friction, friction),))  # type: ignore[arg-type]
        for reference in (Reference("ramp", velocity=0.1), Reference("sine", amplitude=0.1, frequency=1.0)):
            loop = Loop(0.01, 1.0, (JointLoop("X", 30.0, reference, compensation=Compensation("adaptive")),))
            variables = describe(arm, loop, 2)[0].variables
            names = {v.name.removeprefix("joint[1]."): v.unit.name if v.unit else None for v in variables}
            found = [names[f"compensation.{key}"] for key in ("gain[1]", "gain[2]", "gain[3]", "leakage", "omega")]
            units[kind, reference.kind] = found, [names[f"reference.constant[{i}]"] for i in (1, 2, 3, 4)]
    turning, sliding = ["N.m/rad", "N.m/rad", "N.m.s2/rad3"], ["N/m", "N/m", "N.s2/m3"]
    assert units == {
        ("revolute", "ramp"): ([*turning, None, "rad/s"], ["rad", "rad/s", None, None]),
        ("revolute", "sine"): ([*turning, None, "rad/s"], ["rad", "rad", "rad/s", "rad"]),
        ("prismatic", "ramp"): ([*sliding, None, "rad/s"], ["m", "m/s", None, None]),
        ("prismatic", "sine"): ([*sliding, None, "rad/s"], ["m", "m", "rad/s", "rad"]),
    }


@pytest.mark.parametrize(
    ("name", "wrong", "least"),
    [
        ("friction.alpha", 0.0, 1e-9),
        ("torque_limit", -1.0, 0.0),
        ("velocity_filter", -0.01, 0.0),
        ("friction.C0", -1.0, 0.0),
    ],
)
def test_controller_refuses_what_its_laws_cannot_take(
    controller_fmu: Path, loop: Loop, name: str, wrong: float, least: float
) -> None:
    with slave(controller_fmu) as controller:
        (described,) = (v for v in controller.description.modelVariables if v.name == f"joint[1].{name}")
        assert float(described.min) == least
        read, write = (
            getattr(controller.fmu, f"{way}{'Real' if controller.two else 'Float64'}") for way in ("get", "set")
        )
        before = read([described.valueReference])
        with pytest.raises(Exception, match=r"[sS]et(Real|Float64)"):
            write([described.valueReference], [wrong])
        assert read([described.valueReference]) == before
        controller.begin()
        controller.step(0.0, loop.sample_time)
        assert np.all(np.isfinite(controller.get("tau", 2)))


def test_controller_samples_in_any_communication_step(controller_fmu: Path, loop: Loop) -> None:
    """Torque of a motion q = 0.01 sin t seen in steps of the sample time and of a seventh of it."""
    step, outcomes = loop.sample_time, []
    for parts in (1, 7):
        torques = []
        with slave(controller_fmu) as controller:
            controller.begin()
            for i in range(40):
                for part in range(parts):
                    t = (i + part / parts) * step
                    controller.set("q", [0.01 * np.sin(t), 0.0])
                    controller.step(t, step / parts)
                torques.append(controller.get("tau", 2))
        outcomes.append(torques)
    np.testing.assert_allclose(outcomes[0], outcomes[1], rtol=0.0, atol=1e-12)
    assert np.ptp(np.array(outcomes[0])[:, 0]) > 0.0


def test_controller_state_rolls_back(controller_fmu: Path, loop: Loop) -> None:
    step = loop.sample_time
    with slave(controller_fmu) as controller:
        controller.begin()

        def go(first: int, last: int) -> list[float]:
            for i in range(first, last):
                controller.set("q", [0.01 * np.sin(i), 0.02 * np.cos(i)])
                controller.step(i * step, step)
            return controller.get("tau", 2)

        go(0, 10)
        fmu = controller.fmu
        two = controller.two
        state = fmu.getFMUstate() if two else fmu.getFMUState()
        blob = fmu.serializeFMUstate(state) if two else fmu.serializeFMUState(state)
        once = go(10, 20)
        (fmu.setFMUstate if two else fmu.setFMUState)(state)
        assert go(10, 20) == once
        restored = fmu.deSerializeFMUstate(bytes(blob)) if two else fmu.deserializeFMUState(bytes(blob))
        (fmu.setFMUstate if two else fmu.setFMUState)(restored)
        assert go(10, 20) == once
        for wrong in (bytes(blob)[:-1], b"x" * len(bytes(blob))):
            with pytest.raises(Exception, match=r"[dD]e[sS]erialize"):
                (fmu.deSerializeFMUstate if two else fmu.deserializeFMUState)(wrong)
        (fmu.freeFMUstate if two else fmu.freeFMUState)(state)


def test_system_in_ssp_is_the_loop_one_sample_later(arm: Arm, loop: Loop, tmp_path: Path) -> None:
    export_system(arm, loop, tmp_path / "loop.ssp", platforms=HERE)
    found = simulate_ssp(str(tmp_path / "loop.ssp"), stop_time=2.0 - 1e-9, step_size=loop.sample_time)
    late = replace(loop, duration=2.0, joints=tuple(replace(joint, delay_samples=1) for joint in loop.joints))
    expected = simulate_loop(arm, late, tolerance=1e-9)
    for k in range(arm.n):
        np.testing.assert_allclose(found[f"arm.q[{k + 1}]"], expected.measured[1:, k], rtol=0.0, atol=1e-8)
    assert expected.measured[-1, 0] > 0.05


REST = Reference("regulate")
REFUSED = {
    "continuous": (Loop(0.0, 1.0, (JointLoop("A", 30.0, REST), JointLoop("B", 30.0, REST))), "continuous"),
    "clamped": (Loop(0.01, 1.0, (JointLoop("A", 30.0, REST),)), "cannot hold a joint still: found B"),
    "lag": (
        Loop(0.01, 1.0, (JointLoop("A", 30.0, REST, actuator_lag=0.01), JointLoop("B", 30.0, REST))),
        "drive's lag",
    ),
    "noise": (
        Loop(0.01, 1.0, (JointLoop("A", 30.0, REST), JointLoop("B", 30.0, REST, encoder_noise=1e-5))),
        "no noise",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_a_controller_cannot_carry(arm: Arm, tmp_path: Path, name: str) -> None:
    refused, says = REFUSED[name]
    with pytest.raises(InputError, match=says):
        export_controller(arm, refused, tmp_path / "controller.fmu")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_every_law_and_reference_in_a_controller_fmu(arm: Arm, tmp_path: Path, arm_fmu: Path) -> None:
    sine = Reference("sine", amplitude=0.2, frequency=0.7, phase=0.3)
    steps = Reference("steps", times=(0.2, 0.6), values=(0.1, -0.1))
    followed = Reference(
        "file", file="run.csv", times=tuple(np.linspace(0, 1, 11)), values=tuple(0.1 * np.sin(np.linspace(0, 3, 11)))
    )
    laws = (
        Compensation("adaptive", ratio=0.7), Compensation("feedback", at_zero="hold", dead_band=0.01),
        Compensation("robust", inner=1e-3), Compensation("dither", amplitude=1.0, frequency=10.0),
    )  # fmt: skip
    for i, law in enumerate(laws):
        first = JointLoop("A", 60.0, (sine, steps, followed, REST)[i], ki=5.0, delay_samples=i, compensation=law)
        second = JointLoop("B", 60.0, sine, velocity="true", velocity_filter=0.01, encoder_resolution=1e-5, start=0.1)
        loop = Loop(0.01, 1.0, (second, first))
        path = tmp_path / f"{law.kind}.fmu"
        export_controller(arm, loop, path, fmi=3, platforms=HERE)
        expected = simulate_loop(arm, loop, tolerance=1e-9)
        with slave(path) as controller, slave(arm_fmu) as plant:
            controller.begin()
            plant.begin(q_start=list(expected.measured[0]))
            for k in range(100):
                controller.set("q", plant.get("q", 2))
                controller.set("dq", plant.get("dq", 2))
                controller.step(k * 0.01, 0.01)
                plant.set("tau", controller.get("tau", 2))
                plant.step(k * 0.01, 0.01)
            np.testing.assert_allclose(plant.get("q", 2), expected.motion.q[-1], rtol=0.0, atol=1e-6, err_msg=law.kind)


@ONE_VERSION
def test_command_writes_a_run_of_the_fmu(
    arm_fmu: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("stribeck.report.simulation.png", lambda figure: b"drawn")  # as the engine's own runs are
    loop = str(MODELS / "two_link_nominal" / "loop.toml")
    assert main(["simulate", "--fmu", str(arm_fmu), loop, "--out", str(tmp_path / "out")]) == 0
    run = load_run(tmp_path / "out" / "simulation.csv", 2)
    expected = table(MODELS / "two_link_nominal" / "loop_reference.csv")
    np.testing.assert_allclose(run.q[:, 0], expected["q1"], rtol=0.0, atol=1e-8)
    assert {path.name for path in (tmp_path / "out").iterdir()} >= {"simulation.csv", "simulation.json", "motion_1.png"}
    assert capsys.readouterr().err == ""
    other = str(MODELS / "one_joint" / "arm.toml")
    assert main(["simulate", "--fmu", str(arm_fmu), other, loop, "--out", str(tmp_path / "no")]) == 2
    assert "is not a joint of this arm" in capsys.readouterr().err
    assert not (tmp_path / "no").exists()


@ONE_VERSION
def test_nominal_arm_may_differ_from_the_fmu(arm_fmu: Path, arm: Arm, loop: Loop) -> None:
    """Less friction known than there is: the error that compensation leaves grows."""
    joints = (replace(arm.joints[0], friction=replace(arm.joints[0].friction, C0=3.0)), arm.joints[1])
    unaware = simulate_fmu(arm_fmu, replace(arm, joints=joints), loop)
    aware = simulate_fmu(arm_fmu, arm, loop)
    assert np.abs(unaware.error[-1, 0]) > 2.0 * np.abs(aware.error[-1, 0])
    assert load_arm(MODELS / "two_link_nominal" / "arm.toml") == arm


def test_what_is_wrong_with_an_fmu_is_said_of_its_own_files(
    arm_fmu: Path, arm: Arm, loop: Loop, tmp_path: Path, fmi: int
) -> None:
    file = str(MODELS / "two_link_nominal" / "loop.toml")
    odd = changed(arm_fmu, tmp_path / "odd.fmu", {"resources/arm.toml": swap("stribeck.arm/1", "stribeck.arm/9")})
    with pytest.raises(InputError, match=r"odd.fmu: resources/arm.toml: schema must be .*found 'stribeck.arm/9'"):
        load_fmu_loop(odd, None, Path(file))
    here = f"binaries/{fmpy.platform if fmi == 2 else fmpy.platform_tuple}/"
    with zipfile.ZipFile(arm_fmu) as archive:
        (binary,) = (name for name in archive.namelist() if name.startswith(here))
    spoilt = changed(arm_fmu, tmp_path / "spoilt.fmu", {binary: lambda data: b"no library"})
    with pytest.raises(InputError, match=f"spoilt.fmu: cannot be loaded: found {binary}: "):
        simulate_fmu(spoilt, arm, loop)
