"""Question: what does a compiled FMU gain over one with Python inside, a driver in C over FMPy? Factors of 10 to 1,000.

Method: the two-link arm of ``fmu/two_link_nominal`` under its torques for 5 s, 21 stick-slip events. Exported by
stribeck, and written by hand for PythonFMU3 (`_python_arm.py`): in fixed steps of 1 ms, and with `solve_ivp` and its
events at 1e-9. FMI 3, two platforms each, through the same calls of FMPy in one process; CPU time, which other work on
the machine disturbs least, the quickest of several in turn. Thousands of simulations at steps of 10 ms, with other
masses, through our batch driver on two threads, beside one through FMPy.
Expected: a step of 1 ms in some microseconds, most of them FMPy's call, and in some tens to hundreds with Python; the
same accuracy as Python's with events; 10,000 simulations in 10 s on two cores, so 20 s of CPU time.
Source: the project's own acceptance figures; PythonFMU3 (pip).
"""

from __future__ import annotations

import os

os.environ["OMP_NUM_THREADS"] = "1"  # read when numpy is first imported

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import typer
from _importers import FMU
from _output import write
from _python_fmu import batch, beside, by_simulate_fmu, python_fmu, version
from _python_fmu_figure import work_and_precision
from rich import print as show

from stribeck.arm import load_arm
from stribeck.export import export_fmu

MODEL = FMU / "two_link_nominal"


def main(simulations: int = 10_000, repeats: int = 3) -> None:
    """Compare all; ``--simulations N`` sets the size of the batch."""
    given, table = (np.genfromtxt(MODEL / f"{name}.csv", delimiter=",", names=True) for name in ("input", "reference"))
    with TemporaryDirectory() as name:
        fmu, theirs = Path(name) / "arm.fmu", python_fmu(Path(name))
        export_fmu(load_arm(MODEL / "arm.toml"), fmu, fmi=3, platforms=["x86_64-linux", "x86_64-windows"])
        fmus = {"compiled": fmu, "python_fixed_steps": theirs, "python_events": theirs}
        result = beside(fmus, given, np.column_stack([table["q1"], table["q2"]]), repeats)
        result["batch"] = batch(fmu, given, simulations)
        result["simulate_fmu_ms"] = 1e3 * min(by_simulate_fmu(fmu, given) for _ in range(repeats))
    one = result["batch"]["simulation_ms"]
    times = {name: result[name]["simulation_ms"] / one for name in fmus} | {
        "simulate_fmu": result["simulate_fmu_ms"] / one
    }
    result |= {"times_batch": times, "load_average": os.getloadavg()[0], "pythonfmu3": version()}
    show(result)
    print(f"written to {write('python_fmu', result, work_and_precision=work_and_precision(result))}")


if __name__ == "__main__":
    typer.run(main)
