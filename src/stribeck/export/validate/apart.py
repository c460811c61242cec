"""Ask a process of its own for a simulation of an FMU, and say in one line why there is none."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stribeck.errors import StribeckError

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Trial:
    """A simulation to ask for.

    Attributes
    ----------
    folder : str
        The unpacked FMU.
    kind : str
        ``CoSimulation`` or ``ModelExchange`` (then with CVode).
    stop, interval : float
        End and distance of the rows, s.
    outputs : tuple of str
        Variables to record.
    tolerance : float or None
        Relative.
    start : float
        s.
    start_values : dict
        Variable -> value.
    library : str or None
        The binary, where it is not the one in the FMU.
    seconds : float
        Time that the process may take, s.
    """

    folder: str
    kind: str
    stop: float
    interval: float
    outputs: tuple[str, ...]
    tolerance: float | None = None
    start: float = 0.0
    start_values: dict[str, float] = field(default_factory=dict)
    library: str | None = None
    seconds: float = 60.0


def held_inputs(times: Floats, values: Floats, names: tuple[str, ...]) -> np.ndarray:
    """Return fmpy's table of inputs (M, m) each held until the next: two rows an instant."""
    at = np.repeat(np.arange(len(times)), 2)[1:]
    held = np.repeat(np.arange(len(times)), 2)[:-1]
    table = np.zeros(len(at), dtype=[("time", float), *((name, float) for name in names)])
    table["time"] = times[at]
    for k, name in enumerate(names):
        table[name] = values[held, k]
    return table


def simulate_apart(trial: Trial, inputs: np.ndarray | None = None) -> tuple[Floats, Floats]:
    """Simulate an FMU in a process of its own.

    Returns
    -------
    time : array (M,)
        s.
    outputs : array (M, number of outputs)

    Raises
    ------
    StribeckError
        When the process failed, was ended by a signal, took too long or too much memory.
    """
    with tempfile.TemporaryDirectory(prefix="stribeck.trial.") as name:
        folder = Path(name)
        if inputs is not None:
            np.save(folder / "inputs.npy", inputs, allow_pickle=False)
        request = asdict(trial) | {"inputs": None if inputs is None else str(folder / "inputs.npy")}
        (folder / "request.json").write_text(json.dumps(request), encoding="utf-8")
        status = _call(folder, trial.seconds)
        if status != 0 or not (folder / "result.npz").exists():
            raise StribeckError(f"{_words(trial.kind)} failed {_reason(folder, status, trial.seconds)}")
        try:
            with np.load(folder / "result.npz", allow_pickle=False) as held:
                columns = [np.asarray(held[str(k)], dtype=float) for k in range(len(trial.outputs) + 1)]
        except (ValueError, OSError, KeyError) as error:
            raise StribeckError(f"{_words(trial.kind)} gave no result", str(error)) from error
    return columns[0], np.stack(columns[1:], axis=1) if trial.outputs else np.zeros((len(columns[0]), 0))


def _call(folder: Path, seconds: float) -> int | None:
    """Run the process; return its exit status, None where it took too long."""
    script = str(Path(__file__).with_name("trial.py"))
    command = [sys.executable, "-P", script, str(folder / "request.json"), str(folder)]
    child = subprocess.Popen(
        command, cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        start_new_session=True,
    )  # fmt: skip
    try:
        return child.wait(timeout=seconds + 20.0)
    except subprocess.TimeoutExpired:
        return None
    finally:
        if child.poll() is None:
            # the FMU may have started processes of its own
            if hasattr(os, "killpg"):
                os.killpg(child.pid, signal.SIGKILL)
            else:
                child.kill()
            child.wait()


def _reason(folder: Path, status: int | None, seconds: float) -> str:
    stage = (folder / "stage.txt").read_text() if (folder / "stage.txt").exists() else "starting"
    if status is None or status in (-getattr(signal, "SIGXCPU", 0), -signal.SIGKILL if os.name == "posix" else 0):
        return f"while {stage}: it took longer than {seconds:g} s"
    if status < 0:
        return f"while {stage}: the binary crashed with {signal.Signals(-status).name}"
    told = folder / "failure.txt"
    text = told.read_text(encoding="utf-8", errors="replace") if told.exists() else f"exit status {status}"
    return f"while {stage}: {' '.join(text.split())[:250]}"


def _words(kind: str) -> str:
    return {"CoSimulation": "Co-Simulation", "ModelExchange": "Model Exchange"}.get(kind, kind)
