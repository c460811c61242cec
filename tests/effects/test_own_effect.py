"""An effect of one's own package, laid out as pip installs it, is found beside the library's."""

import importlib
import os
import subprocess
import sys
from pathlib import Path

import pytest

STUDIES = Path(__file__).parents[2] / "studies"
LIST = "from stribeck.effects.registry import registry; print(*registry())"


def test_an_installed_effect_is_known(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(STUDIES))
    site = importlib.import_module("_installed").installed(STUDIES / "own_effect", tmp_path / "site")
    points = next(site.glob("*.dist-info/entry_points.txt")).read_text(encoding="utf-8")
    assert points == "[stribeck.effects]\ndrive_hardening = drive_hardening:DriveHardening\n"
    env = {**os.environ, "PYTHONPATH": os.pathsep.join([str(site), *sys.path])}
    done = subprocess.run([sys.executable, "-c", LIST], env=env, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split()[-1] == "drive_hardening"
