"""Four independent importers, a program in C, and the Windows binary in wine: all equal to the simulator."""

import json
import subprocess
import sys

import pytest

from .conftest import ROOT


@pytest.mark.slow
def test_all_importers_agree_with_the_simulator() -> None:
    done = subprocess.run(
        [sys.executable, "importers.py"], cwd=ROOT / "studies", capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    result = json.loads((ROOT / "studies/out/importers/result.json").read_text(encoding="utf-8"))
    found = result["largest_departure_rad"]
    missing = {name: text for name, text in found.items() if isinstance(text, str)}
    for name, value in found.items():
        if name not in missing:
            bound = 1e-12 if "less" in name else 1e-6 if "Exchange" in name else 1e-8
            assert value < bound, name
    assert "FMPy, FMI 2" not in missing
    assert "C, Linux" not in missing
    if missing:
        pytest.skip("; ".join(f"{name}: {text}" for name, text in missing.items()))
