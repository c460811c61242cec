"""Many simulations of one Co-Simulation FMU, on several threads, each in C from its first step to its last."""

from __future__ import annotations

import ctypes
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

import fmpy
import numpy as np
from joblib import Parallel, delayed
from numpy.typing import NDArray

from stribeck.compiler import build, load
from stribeck.errors import InputError
from stribeck.export.validate.opened import Opened, opened

Floats = NDArray[np.float64]

_NAMES = {
    2: ("Instantiate", "SetReal", "GetReal", "SetupExperiment", "EnterInitializationMode", "ExitInitializationMode",
        "DoStep", "Reset", "FreeInstance"),
    3: ("InstantiateCoSimulation", "SetFloat64", "GetFloat64", "EnterInitializationMode", "EnterInitializationMode",
        "ExitInitializationMode", "DoStep", "Reset", "FreeInstance"),
}  # fmt: skip
_CHUNKS = 4  # a thread: what one of them takes longer is shared


@dataclass(frozen=True)
class Batch:
    """R simulations of M samples.

    Attributes
    ----------
    outputs : array (R, M, outputs)
        Not a number from the sample on that was not reached.
    reached : array (R,) of int
        Samples that each simulation reached.
    """

    outputs: Floats
    reached: NDArray[np.int64]


def simulate_batch(
    fmu: Path | str,
    times: Floats,
    command: Floats,
    values: Mapping[str, Floats],
    *,
    inputs: Sequence[str],
    outputs: Sequence[str],
    tolerance: float = 1e-8,
    jobs: int = -1,
) -> Batch:
    """Simulate an FMU many times, with other parameter values or initial conditions each time.

    Parameters
    ----------
    fmu : path
        With Co-Simulation and a binary for this machine. Its code runs in this process: for trusted files only.
    times : array (M,)
        Communication points, s.
    command : array (M, inputs) or (R, M, inputs)
        Values of the inputs, held from each instant to the next; the same for all simulations, or of each.
    values : mapping of str to array (R,)
        What is set before each simulation: parameters and initial conditions by name, in SI.
    inputs, outputs : sequence of str
        Names of variables.
    tolerance : float
        Told to the FMU.
    jobs : int
        Threads; all cores where -1.

    Raises
    ------
    InputError
        When the FMU cannot be simulated here, a variable is not known or the shapes do not fit.
    """
    times, command = np.ascontiguousarray(times, dtype=float), np.ascontiguousarray(command, dtype=float)
    columns = [np.asarray(column, dtype=float) for column in values.values()]
    runs = len(columns[0]) if columns else (len(command) if command.ndim == 3 else 1)
    wanted = (runs, len(times), len(inputs))
    if command.shape not in (wanted, wanted[1:]) or any(column.shape != (runs,) for column in columns):
        raise InputError(
            "shapes of command and values do not fit", str(command.shape), f"give {wanted}, or {wanted[1:]}"
        )
    table = np.ascontiguousarray(np.stack(columns, axis=1) if columns else np.zeros((runs, 0)))
    count = os.cpu_count() or 1 if jobs == -1 else jobs
    result = Batch(np.full((runs, len(times), len(outputs)), np.nan), np.zeros(runs, dtype=np.int64))
    with opened(fmu) as unpacked:
        names = [_references(unpacked, group) for group in (list(values), inputs, outputs)]
        call = _driver(unpacked, names, table, command, times, tolerance, result)
        edges = np.unique(np.linspace(0, runs, count * _CHUNKS + 1).astype(int))
        parts = zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True)
        done = Parallel(n_jobs=count, prefer="threads")(delayed(call)(first, last) for first, last in parts)
    if not all(done):
        raise InputError(f"{fmu}: cannot be instantiated for Co-Simulation", "", "see stribeck validate-fmu")
    return result


def _driver(
    fmu: Opened, names: list[np.ndarray], values: Floats, command: Floats, times: Floats, tolerance: float,
    result: Batch,
) -> Callable[[int, int], bool]:  # fmt: skip
    """Return a function of the first and last simulation that runs them, as C does without Python's lock."""
    drive = load(build((files("stribeck.export.batch") / "drive.c").read_text(encoding="utf-8"))).drive
    library = ctypes.CDLL(str(_binary(fmu)))
    prefix = f"fmi{fmu.version}"
    addresses = [ctypes.cast(getattr(library, prefix + name), ctypes.c_void_p) for name in _NAMES[fmu.version]]
    table = (ctypes.c_void_p * len(addresses))(*[address.value for address in addresses])
    token = (fmu.description.guid if fmu.version == 2 else fmu.description.instantiationToken).encode()
    sets, ins, outs = names
    big, pointer = ctypes.c_longlong, _pointer

    def call(first: int, last: int) -> bool:
        return bool(
            drive(
                fmu.version, table, token, big(first), big(last), pointer(sets), big(len(sets)), pointer(values),
                pointer(ins), big(len(ins)), pointer(command), int(command.ndim == 2), pointer(outs), big(len(outs)),
                pointer(times), big(len(times)), ctypes.c_double(tolerance), pointer(result.outputs),
                pointer(result.reached),
            )
        )  # fmt: skip

    return call


def _pointer(array: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


def _references(fmu: Opened, names: Sequence[str]) -> np.ndarray:
    if fmu.description is None or "CoSimulation" not in fmu.kinds:
        raise InputError(f"{fmu.source}: has no Co-Simulation", "", "see stribeck validate-fmu")
    known = {variable.name: variable.valueReference for variable in fmu.description.modelVariables}
    for name in names:
        if name not in known:
            raise InputError(f"{fmu.source}: unknown variable", name, "see its modelDescription.xml")
    return np.array([known[name] for name in names], dtype=np.uint32)


def _binary(fmu: Opened) -> Path:
    folder = fmpy.platform if fmu.version == 2 else fmpy.platform_tuple
    name = f"binaries/{folder}/{fmu.kinds['CoSimulation']}{fmpy.sharedLibraryExtension}"
    if name not in fmu.files:
        raise InputError(f"{fmu.source}: no binary for this machine", name, "export it for this platform too")
    return fmu.folder / name
