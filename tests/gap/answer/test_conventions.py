"""Recordings in another convention than the arm file are told of, and in which; no effect is taken for one."""

from dataclasses import replace
from functools import cache
from importlib.resources import files

import numpy as np
import pytest

from stribeck.arm import Arm, load_arm
from stribeck.effects.placing import entries_of
from stribeck.effects.registry import effect_named, registry
from stribeck.errors import WARNING
from stribeck.gap.answer.conventions import told_conventions
from stribeck.gap.diagnose import diagnose
from stribeck.gap.records.prepare import Prepared, prepare
from stribeck.identify.residual import Residual
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath
from stribeck.run import Run, load_runs

from ..conftest import NOMINAL, recorded


@cache
def example() -> tuple[Arm, tuple[Run, ...]]:
    folder = files("stribeck") / "example"
    arm = load_arm(str(folder / "arm.toml"))
    return arm, tuple(load_runs([str(folder / f"run_0{k}.csv") for k in range(3)], arm.n))


def with_columns(run: Run, position: list[list[float]], torque: list[list[float]]) -> Run:
    return replace(run, q=run.q @ np.transpose(position), tau=run.tau @ np.transpose(torque))


def told(arm: Arm, runs: list[Run]) -> list[str]:
    prepared = prepare(arm, runs)
    return told_conventions(prepared, given(prepared))


def given(prepared: Prepared) -> np.ndarray:
    path = SignalPath(prepared.arm)
    return Residual(path, prepared.held, ())(values_of(path.entries))[0]


MIRRORED = "position and torque of {} turned the other way"  # on a level stand either is
SAME, SECOND, EXCHANGED, ABSOLUTE = [[1, 0], [0, 1]], [[1, 0], [0, -1]], [[0, 1], [1, 0]], [[1, 0], [1, 1]]


@pytest.mark.parametrize(
    ("position", "torque", "text"),
    [
        (SECOND, SAME, "the position of B turned the other way"),
        (SAME, SECOND, "the torque of B turned the other way"),
        (SECOND, SECOND, f"{MIRRORED.format('A')} or {MIRRORED.format('B')}"),
        (SAME, EXCHANGED, "the torques of A and B exchanged"),
        (EXCHANGED, SAME, "the positions of A and B exchanged"),
        (EXCHANGED, EXCHANGED, "A and B exchanged"),
        (ABSOLUTE, SAME, "positions taken as angles against the base"),
    ],
)
def test_it_is_told_what_would_fit(position: list[list[float]], torque: list[list[float]], text: str) -> None:
    arm, runs = example()
    (said,) = told(arm, [with_columns(run, position, torque) for run in runs])
    assert said.startswith(f"with {text}, the arm file's model leaves ")
    left, recorded = (float(said.split(before)[1].split()[0].rstrip(":")) for before in (" leaves ", " as recorded "))
    assert left < 0.5 * recorded


def test_of_recordings_in_the_arm_files_own_nothing_is_told() -> None:
    arm, runs = example()
    assert told(arm, list(runs)) == []


@pytest.mark.parametrize(
    "effect",
    [
        ("torque_gain", {"gain": 0.4}),
        ("payload", {"mass": 6.0}),
        ("torque_offset", {"offset": 15.0}),
        ("quadratic_damping", {"coefficient": 8.0}),
        ("delay", {"time": 0.05}),
        ("cable_spring", {"stiffness": 60.0, "rest": 0.5}),
    ],
)
def test_a_gap_however_large_is_no_convention(effect: tuple[str, dict[str, float]]) -> None:
    prepared = prepare(NOMINAL, recorded(effect))
    command = np.concatenate([run.filtered(run.command) for run in prepared.held])
    assert np.std(given(prepared)) > 0.3 * np.std(command)
    assert told_conventions(prepared, given(prepared)) == []


def test_effects_of_the_arm_file_are_in_its_model() -> None:
    """A spring that the file has does not make recordings of it look strange, nor hide that they are."""
    spring = Placed(effect_named("cable_spring"), 0, {"stiffness": 60.0, "rest": 0.5})
    arm = replace(NOMINAL, effects=entries_of(NOMINAL, [spring]))
    runs = recorded(("cable_spring", dict(spring.values)))
    assert told(arm, list(runs)) == []
    turned = [replace(run, tau=-run.tau) for run in runs]
    prepared = prepare(arm, turned)
    (said,) = told_conventions(prepared, given(prepared))
    assert said.startswith("with the torque of A turned the other way, the arm file's model leaves ")


def test_a_brake_goes_with_its_columns() -> None:
    """Else nothing would be left at a joint that takes the place of one that is held."""
    arm, runs = example()
    held = [replace(run, q=run.q * [1.0, 0.0] + [0.0, 0.3], tau=run.tau * [1.0, 0.0]) for run in runs]
    assert told(arm, held) == []
    weak = replace(arm, joints=tuple(replace(j, friction=replace(j.friction, C0=30.0, C1=0.0)) for j in arm.joints))
    assert told(weak, held) == []


def test_a_diagnosis_warns_of_it() -> None:
    runs = [replace(run, tau=-run.tau) for run in recorded()]
    said: list[str] = []
    others = [name for name in registry() if name != "delay"]
    found = diagnose(NOMINAL, runs, jobs=1, leave_out=others, progress=said.append)
    assert any("with the torque of A turned the other way" in text for text in found.warnings)
    assert not any("check the signs of its torque" in text for text in found.warnings)  # said once
    (first,) = (text for text in said if text.startswith(WARNING))
    assert first.removeprefix(WARNING) in found.warnings
    assert said.index(first) < next(k for k, text in enumerate(said) if text.startswith("screening"))
