"""An effect of one's own package, laid out as pip installs it, is found beside the library's, and named like them."""

import importlib
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from .hardening_arm import DOUBLING, arm_file, recorded

STUDIES = Path(__file__).parents[2] / "studies"
LIST = "from stribeck.effects.registry import registry; print(*registry())"
DIAGNOSE = "from stribeck.cli import main; main()"


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder in which the package of `studies/own_effect` is installed."""
    monkeypatch.syspath_prepend(str(STUDIES))
    return Path(importlib.import_module("_installed").installed(STUDIES / "own_effect", tmp_path / "site"))


def python(code: str, *arguments: str, path: list[str]) -> str:
    """What a process of its own prints that finds what is installed in the folders of `path`."""
    env = {**os.environ, "PYTHONPATH": os.pathsep.join([*path, *sys.path])}
    command = [sys.executable, "-c", code, *arguments]
    done = subprocess.run(command, env=env, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.long
def test_an_installed_effect_is_known(site: Path) -> None:
    points = next(site.glob("*.dist-info/entry_points.txt")).read_text(encoding="utf-8")
    assert points == "[stribeck.effects]\ndrive_hardening = drive_hardening:DriveHardening\n"
    assert python(LIST, path=[str(site)]).split()[-1] == "drive_hardening"


@pytest.mark.slow
def test_an_installed_effect_is_named_where_it_is_the_truth(site: Path, tmp_path: Path) -> None:
    """Recordings of a simulation that is not the library's; without the package nothing can be named rightly."""
    (tmp_path / "arm.toml").write_text(arm_file(), encoding="utf-8")
    runs = [str(tmp_path / f"run_{k}.csv") for k in range(4)]
    for k, run in enumerate(runs):
        np.savetxt(run, recorded(k), fmt="%.9g", delimiter=",", header="t,q1,q2,tau1,tau2", comments="")
    found = {}
    for case, path in (("alone", []), ("with", [str(site)])):
        out = tmp_path / case
        arguments = ("diagnose", str(tmp_path / "arm.toml"), *runs, "--jobs", "1", "--out", str(out))
        python(DIAGNOSE, *arguments, path=path)
        found[case] = json.loads((out / "diagnosis.json").read_text(encoding="utf-8"))
    assert "drive_hardening" not in {cause["effect"] for cause in found["alone"]["causes"]}
    assert found["with"]["named"] == ["drive_hardening"]
    (cause,) = (cause for cause in found["with"]["causes"] if cause["effect"] == "drive_hardening")
    assert cause["joints"] == ["A"]
    value = cause["parameters"]["A"]["doubling"]
    assert value["unit"] == "N m"
    assert value["value"] == pytest.approx(DOUBLING[0], rel=0.05)
    assert found["with"]["gap"]["closed"]["value"] > 0.9
    alone = found["alone"]["gap"]["closed"]  # none where nothing is named
    assert alone is None or found["with"]["gap"]["closed"]["value"] > alone["value"]
