"""The folders in ``fmu/``: complete, reproducible, and true of the FMUs."""

import importlib.util
import re
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from stribeck.arm import load_arm
from stribeck.export import export_fmu

from .conftest import HERE, MODELS, ROOT
from .master import slave

NAMES = ("one_joint", "two_link_nominal", "two_link_corrected")


def regenerate() -> ModuleType:
    specification = importlib.util.spec_from_file_location("regenerate", MODELS / "regenerate.py")
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def table(path: Path) -> np.ndarray:
    return np.genfromtxt(path, delimiter=",", names=True)


@pytest.mark.parametrize("name", NAMES)
def test_references_are_what_the_engine_gives(name: str) -> None:
    given, result = regenerate().reference(name)
    for file, columns in (("input.csv", given), ("reference.csv", result)):
        kept = table(MODELS / name / file)
        assert kept.dtype.names == tuple(columns)
        for key, values in columns.items():
            np.testing.assert_allclose(kept[key], values, rtol=0.0, atol=1e-9 if key[0] in "tq" else 1e-6, err_msg=key)
    modes = [key for key in result if key.startswith("sliding")]
    assert all(np.count_nonzero(np.diff(result[key])) >= 7 for key in modes)


def follow(fmu: Path, name: str) -> float:
    """The largest departure of a joint position from the folder's reference, rad."""
    given, expected = table(MODELS / name / "input.csv"), table(MODELS / name / "reference.csv")
    n = len(given.dtype.names) - 1
    with slave(fmu) as one:
        one.begin()
        worst = 0.0
        for i, t in enumerate(given["t"][:-1]):
            one.set("tau", [given[f"tau{k + 1}"][i] for k in range(n)])
            one.step(t, given["t"][i + 1] - t)
            got = one.get("q", n)
            worst = max(worst, *(abs(got[k] - expected[f"q{k + 1}"][i + 1]) for k in range(n)))
    return worst


def test_nominal_arm_follows_its_reference(arm_fmu: Path) -> None:
    assert 0.0 < follow(arm_fmu, "two_link_nominal") < 1e-8


@pytest.mark.slow
@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("name", ["one_joint", "two_link_corrected"])
def test_others_follow_theirs(tmp_path: Path, name: str, version: int) -> None:
    export_fmu(load_arm(MODELS / name / "arm.toml"), tmp_path / "arm.fmu", fmi=version, platforms=HERE)
    assert 0.0 < follow(tmp_path / "arm.fmu", name) < 1e-8


def test_every_folder_says_how_to_import() -> None:
    text = {name: (MODELS / name / "README.md").read_text() for name in NAMES}
    whole = (MODELS / "README.md").read_text()
    for tool in ("OpenModelica", "Dymola", "Simulink", "FMPy", "Ecos"):
        assert tool in whole
    for name, words in text.items():
        assert f"fmu/{name}/arm.toml" in words
        assert "OpenModelica" in words
        assert "../README.md" in words
    for page, folder in [(whole, MODELS), *((text[name], MODELS / name) for name in NAMES)]:
        for target in re.findall(r"\]\(([^)]+)\)", page):
            assert (folder / target).exists(), target
        for path in re.findall(r"(?<![\w/])fmu/[\w/]+\.\w+", page):
            assert (ROOT / path).exists(), path


def test_modelica_package_knows_the_arm_and_the_loop() -> None:
    text = (MODELS / "StribeckArm.mo").read_text()
    opened = re.findall(r"^\s*(?:partial )?(?:package|model|block|function) (\w+)", text, re.M)
    closed = [name for name in re.findall(r"^\s*end (\w+);", text, re.M) if name != "when"]
    assert sorted(opened) == sorted(closed)
    friction = load_arm(MODELS / "two_link_nominal" / "arm.toml").joints[0].friction
    for name, value in (("c0", friction.C0), ("c1", friction.C1), ("c2", friction.C2), ("alpha", friction.alpha)):
        assert re.search(rf"parameter Real {name}\(unit = \"[^\"]+\"\) = {value:g} ", text), name
