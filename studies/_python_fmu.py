"""An FMU that carries Python beside one that is compiled: both through FMPy's own interface, timed by CPU time."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from _importers import run_other
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi3 import FMU3Slave

from stribeck.export.batch import simulate_batch

HERE = Path(__file__).parent
SETTINGS = {"compiled": {}, "python_fixed_steps": {"tolerance": 0.0}, "python_events": {"tolerance": 1e-9}}


@dataclass(frozen=True)
class Followed:
    """One simulation through FMPy: positions (M, n), rad, CPU time of all calls and of the steps alone, s."""

    q: np.ndarray
    all_calls: float
    steps: float


def python_fmu(folder: Path) -> Path:
    """Return the arm of `_python_arm.py`, packed by PythonFMU3 from the importers' environment."""
    run_other(["-m", "pythonfmu3", "build", "-f", str(HERE / "_python_arm.py"), "-d", str(folder)])
    return folder / "TwoLinkArm.fmu"


def version() -> str:
    """Return PythonFMU3's version."""
    return run_other(["-c", "import pythonfmu3; print(pythonfmu3.__version__)"]).strip()


def followed(fmu: Path, table: np.ndarray, *, divide: int = 1, rows: int = 0, **values: float) -> Followed:
    """Simulate an FMI 3 file as FMPy's users do: torques set, steps done, positions read, row by row.

    Each row's torques are held for ``divide`` steps; ``rows`` of the table where it is not 0.
    """
    with TemporaryDirectory() as folder:
        extract(str(fmu), folder)
        description = read_model_description(folder)
        known = {v.name: v.valueReference for v in description.modelVariables}
        tau, q = ([known[f"{name}[{k + 1}]"] for k in (0, 1)] for name in ("tau", "q"))
        one = FMU3Slave(
            guid=description.instantiationToken, unzipDirectory=folder, instanceName="arm",
            modelIdentifier=description.coSimulation.modelIdentifier,
        )  # fmt: skip
        one.instantiate()
        for name, value in values.items():
            one.setFloat64([known[name]], [value])
        one.enterInitializationMode(tolerance=1e-8)
        one.exitInitializationMode()
        count, steps = rows or len(table), 0.0
        t, torques = table["t"].tolist(), np.column_stack([table["tau1"], table["tau2"]]).tolist()
        h = t[1] / divide
        found = [one.getFloat64(q)]
        begin = time.process_time()
        for i in range(count - 1):
            one.setFloat64(tau, torques[i])
            started = time.process_time()
            for part in range(divide):
                one.doStep(t[i] + part * h, h)
            steps += time.process_time() - started
            found.append(one.getFloat64(q))
        taken = time.process_time() - begin
        one.terminate()
        one.freeInstance()
    return Followed(np.array(found), taken, steps)


def by_simulate_fmu(fmu: Path, table: np.ndarray) -> float:
    """Return the CPU time, s, of FMPy's one-line call under the same torques, unpacking and loading left out."""
    held = np.zeros(2 * len(table) - 1, dtype=[("time", float), ("tau[1]", float), ("tau[2]", float)])
    rows = np.repeat(np.arange(len(table)), 2)
    held["time"] = table["t"][rows[1:]]
    for k in (1, 2):
        held[f"tau[{k}]"] = table[f"tau{k}"][rows[:-1]]
    with TemporaryDirectory() as folder:
        extract(str(fmu), folder)
        description = read_model_description(folder)
        begin = time.process_time()
        simulate_fmu(
            folder, model_description=description, fmi_type="CoSimulation", stop_time=table["t"][-1],
            output_interval=table["t"][1], relative_tolerance=1e-8, input=held, output=["q[1]", "q[2]"],
            record_events=False, timeout=300,
        )  # fmt: skip
        return time.process_time() - begin


def beside(fmus: dict[str, Path], given: np.ndarray, reference: np.ndarray, repeats: int) -> dict[str, Any]:
    """Return size, time and departure of each, all in turn."""
    runs = {name: [] for name in fmus}
    for _ in range(repeats):
        for name, fmu in fmus.items():
            short = followed(fmu, given, divide=10, rows=101, **SETTINGS[name])  # steps of 1 ms for 1 s
            runs[name].append((followed(fmu, given, **SETTINGS[name]), short.steps / 1000))
    return {
        name: {
            "size_kB": fmus[name].stat().st_size / 1e3,
            "step_of_1_ms_us": 1e6 * min(step for _, step in of),
            "simulation_ms": 1e3 * min(run.all_calls for run, _ in of),
            "largest_departure_rad": float(np.abs(of[0][0].q - reference).max()),
        }
        for name, of in runs.items()
    }


def batch(fmu: Path, given: np.ndarray, simulations: int) -> dict[str, float]:
    """Return the time of many simulations through the batch driver."""
    command, outputs = np.column_stack([given["tau1"], given["tau2"]]), {"outputs": ["q[1]", "q[2]"]}
    mass = 4.0 * (1.0 + 0.05 * np.random.default_rng(0).standard_normal(simulations))
    names = {"inputs": ["tau[1]", "tau[2]"], **outputs}
    simulate_batch(fmu, given["t"][:2], command[:2], {"joint[1].mass": mass[:2]}, **names)  # compiles the driver
    wall, used = time.perf_counter(), time.process_time()
    found = simulate_batch(fmu, given["t"], command, {"joint[1].mass": mass}, jobs=2, **names)
    wall, used = time.perf_counter() - wall, time.process_time() - used
    assert (found.reached == len(given)).all()
    return {"simulations": simulations, "wall_s": wall, "cpu_s": used, "simulation_ms": 1e3 * used / simulations}
