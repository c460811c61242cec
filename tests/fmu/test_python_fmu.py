"""The compiled FMU beside the same arm in PythonFMU3, written by hand: another reference for the motion."""

import json
import subprocess
import sys

import pytest

from .conftest import ROOT


@pytest.mark.slow
def test_compiled_beside_python() -> None:
    done = subprocess.run(
        [sys.executable, "python_fmu.py", "--simulations", "500", "--repeats", "1"],
        cwd=ROOT / "studies", capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    result = json.loads((ROOT / "studies/out/python_fmu/result.json").read_text(encoding="utf-8"))
    compiled, events, fixed = (result[name] for name in ("compiled", "python_events", "python_fixed_steps"))
    assert compiled["largest_departure_rad"] < 1e-8
    assert events["largest_departure_rad"] < 1e-8
    assert fixed["largest_departure_rad"] > 1e-5
    assert compiled["size_kB"] < 0.5 * events["size_kB"]
    assert compiled["step_of_1_ms_us"] < 0.3 * fixed["step_of_1_ms_us"]
    assert result["batch"]["simulation_ms"] < 2.0  # 10,000 in 10 s on two cores
    assert result["times_batch"]["compiled"] > 2.0
    assert result["times_batch"]["python_events"] > 20.0
