"""Question: does every importer find the simulator's motion, on Linux and on Windows? Five programs, two interfaces.

Method: the two-link arm of ``fmu/two_link_nominal`` as FMI 2 and FMI 3, under the torques of its input, in FMPy, Ecos,
fmuloader, PathSim and a program in C, the last also with the Windows binary in wine; the largest departure of a joint
position from the reference over 5 s with 21 stick-slip events. Model Exchange in FMPy (CVode) under the same torques,
and in PathSim (Runge-Kutta, zero crossings) under torques straight from row to row for 2 s, against Co-Simulation.
The paper's experiment as an SSP file in Ecos against the loop in the engine. pip brings all but wine, without which
the Windows binary is skipped.
Expected: 1e-8 rad in Co-Simulation, wine and Linux equal to 1e-12 rad, 1e-6 rad in Model Exchange.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import typer
from _importers import FMU, Missing, coupled, follow, from_c, straight
from _importers_figure import importers_figure
from _output import write
from rich import print as show

from stribeck.arm import load_arm
from stribeck.export import export_fmu

MODEL = FMU / "two_link_nominal"
GIVEN = MODEL / "input.csv"


def departure(found: Callable[[], np.ndarray], expected: np.ndarray) -> float | str:
    """Return the largest departure, rad, or what is missing."""
    try:
        return float(np.abs(found()[: len(expected)] - expected).max())
    except Missing as reason:
        return f"skipped: {reason}"


def compare(folder: Path, rows: int = 201) -> dict[str, float | str]:
    """Export, run all and compare."""
    table = np.genfromtxt(MODEL / "reference.csv", delimiter=",", names=True)
    reference = np.column_stack([table["q1"], table["q2"]])
    short = folder / "short.csv"
    short.write_text("\n".join(GIVEN.read_text(encoding="utf-8").splitlines()[: rows + 1]) + "\n", encoding="utf-8")
    found: dict[str, float | str] = {}
    for fmi in (2, 3):
        fmu = folder / f"arm{fmi}.fmu"
        export_fmu(load_arm(MODEL / "arm.toml"), fmu, fmi=fmi, platforms=["x86_64-linux", "x86_64-windows"][: 4 - fmi])
        for name in ("FMPy", "Ecos", "fmuloader", "PathSim"):
            found[f"{name}, FMI {fmi}"] = departure(lambda n=name, f=fmu: follow(n.lower(), f, GIVEN), reference)
        exchange = departure(lambda f=fmu: follow("fmpy", f, GIVEN, "ModelExchange"), reference)
        found[f"FMPy, FMI {fmi}, Model Exchange"] = exchange
    two, three = folder / "arm2.fmu", folder / "arm3.fmu"
    line = straight(two, short)
    for fmi, fmu in ((2, two), (3, three)):
        run = departure(lambda f=fmu: follow("pathsim", f, short, "ModelExchange"), line)
        found[f"PathSim, FMI {fmi}, Model Exchange"] = run
    linux = from_c(two, GIVEN, windows=False)
    found["C, Linux"] = departure(lambda: linux, reference)
    found["C, Windows in wine"] = departure(lambda: from_c(two, GIVEN, windows=True), reference)
    found["wine less Linux"] = departure(lambda: from_c(two, GIVEN, windows=True), linux)
    system, engine = coupled(MODEL, folder)
    found["Ecos, SSP of arm and controller"] = departure(lambda: system, engine)
    return found


def main() -> None:
    """Compare all and write the figures."""
    with TemporaryDirectory() as folder:
        found = compare(Path(folder))
    show(found)
    print(f"written to {write('importers', {'largest_departure_rad': found}, departures=importers_figure(found))}")


if __name__ == "__main__":
    typer.run(main)
