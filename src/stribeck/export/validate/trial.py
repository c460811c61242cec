"""Run an FMU in a process of its own: what crashes, hangs or eats memory there does no harm here.

A script of its own, so that the process loads fmpy and nothing else. Arguments: the request (JSON) and the folder for
the answer: ``result.npz``, or ``failure.txt``; ``stage.txt`` says how far it came.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

MEMORY = 4 << 30  # bytes of address space
LARGEST_OUTPUT = 256 << 20  # bytes of any file


def limit(seconds: float) -> None:
    """Bound what this process may take."""
    try:
        import resource
    except ImportError:  # Windows: the time limit of the parent has to do
        return
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (int(seconds) + 1, int(seconds) + 2))
    resource.setrlimit(resource.RLIMIT_FSIZE, (LARGEST_OUTPUT, LARGEST_OUTPUT))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def run(request: dict[str, Any], answer: Path) -> None:
    """Simulate as requested and write the recorded variables."""
    import numpy as np
    from fmpy import read_model_description, simulate_fmu
    from fmpy.simulation import instantiate_fmu

    def stage(text: str) -> None:
        (answer / "stage.txt").write_text(text)

    stage("reading")
    description = read_model_description(request["folder"], validate=False)
    inputs = None if request["inputs"] is None else np.load(request["inputs"], allow_pickle=False)
    stage("loading the binary")
    fmu = instantiate_fmu(request["folder"], description, request["kind"], library_path=request["library"])
    says = fmu.getVersion() if hasattr(fmu, "getVersion") else b""
    says = says.decode() if isinstance(says, bytes) else str(says)
    if says and not says.startswith(description.fmiVersion[:1]):
        raise ValueError(f"the binary says FMI {says}, the description {description.fmiVersion}")
    stage("simulating")
    result = simulate_fmu(
        request["folder"], validate=False, fmi_type=request["kind"], model_description=description, fmu_instance=fmu,
        start_time=request["start"], stop_time=request["stop"], output_interval=request["interval"],
        relative_tolerance=request["tolerance"], start_values=request["start_values"], input=inputs,
        output=request["outputs"], timeout=request["seconds"], record_events=False,
    )  # fmt: skip
    stage("ending")
    columns = {str(k): result[name] for k, name in enumerate(result.dtype.names)}
    np.savez(answer / "result.npz", **columns)
    fmu.freeInstance()
    stage("done")


if __name__ == "__main__":
    wanted = json.loads(Path(sys.argv[1]).read_text())
    limit(wanted["seconds"])
    try:
        run(wanted, Path(sys.argv[2]))
    except BaseException as error:
        (Path(sys.argv[2]) / "failure.txt").write_text(f"{type(error).__name__}: {error}"[:2000])
        sys.exit(1)
