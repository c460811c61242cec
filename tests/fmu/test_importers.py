"""Four independent importers, a program in C, and the Windows binary in wine: all equal to the simulator."""

import json
import subprocess
import sys

import pytest

from .conftest import ROOT

pytestmark = pytest.mark.slow
IMPORTERS = [f"{name}, FMI {fmi}" for name in ("FMPy", "Ecos", "fmuloader", "PathSim") for fmi in (2, 3)]
EXCHANGE = [f"{name}, FMI {fmi}, Model Exchange" for name in ("FMPy", "PathSim") for fmi in (2, 3)]
WINDOWS = ["C, Windows in wine", "wine less Linux"]


@pytest.fixture(scope="module")
def found() -> dict[str, float | str]:
    """The largest departure of each importer, rad; a text where it could not be run, which only wine's may be."""
    done = subprocess.run(
        [sys.executable, "importers.py"], cwd=ROOT / "studies", capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    text = (ROOT / "studies/out/importers/result.json").read_text(encoding="utf-8")
    departures: dict[str, float | str] = json.loads(text)["largest_departure_rad"]
    return departures


def test_nothing_else_was_compared(found: dict[str, float | str]) -> None:
    assert set(found) == {*IMPORTERS, *EXCHANGE, *WINDOWS, "C, Linux", "Ecos, SSP of arm and controller"}


@pytest.mark.parametrize("name", [*IMPORTERS, "C, Linux", "Ecos, SSP of arm and controller"])
def test_steps_as_the_simulator_does(found: dict[str, float | str], name: str) -> None:
    value = found[name]
    assert isinstance(value, float), value
    assert value < 1e-8


@pytest.mark.parametrize("name", EXCHANGE)
def test_integrates_as_the_simulator_does(found: dict[str, float | str], name: str) -> None:
    value = found[name]
    assert isinstance(value, float), value
    assert value < 1e-6


@pytest.mark.parametrize(("name", "bound"), [("C, Windows in wine", 1e-8), ("wine less Linux", 1e-12)])
def test_windows(found: dict[str, float | str], name: str, bound: float) -> None:
    value = found[name]
    if isinstance(value, str):
        pytest.skip(value)
    assert value < bound
