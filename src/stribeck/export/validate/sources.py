"""Whether the sources inside an FMU build, with the compiler that comes with ziglang, on this machine."""

from __future__ import annotations

import os
import platform
import re
import subprocess
import sys
from pathlib import Path, PurePosixPath
from typing import Any

import fmpy

from stribeck.export.validate.binaries import header_functions
from stribeck.export.validate.includes import outside
from stribeck.export.validate.opened import Opened

_LONGEST_BUILD = 300.0  # s
_LONGEST_COMPUTING = 60  # s of processor time
_MEMORY = 4 << 30  # bytes of address space
_C_WORD = re.compile(r"[A-Za-z_]\w{0,99}", re.ASCII)


def build_sources(fmu: Opened, target: Path | None) -> tuple[list[str], list[str]]:
    """Build the sources of an FMU as a shared library.

    A compiler does much of what a source asks for: those that are not trusted are only looked at.

    Parameters
    ----------
    fmu : Opened
    target : path or None
        The library to make; None to look at the sources alone.

    Returns
    -------
    problems, skipped : lists of str
        The library exists where both are empty.
    """
    configurations = fmu.description.buildConfigurations
    if not configurations:
        held = any(file.startswith("sources/") for file in fmu.files)
        return [], ["build of the sources: the FMU does not say how" if held else "build of the sources: it has none"]
    if reads := outside(fmu, configurations[0].sourceFileSets):
        return [reads], []
    arguments: list[str] = []
    for files in configurations[0].sourceFileSets:
        if (files.language or "C99").startswith("C++"):
            return [], [f"build of the sources: they are in {files.language}"]
        found, problems = _arguments(fmu, files)
        if problems:
            return problems, []
        arguments += found
    if target is None:
        return [], ["build of the sources: not asked for"]
    return _build(fmu, arguments, target)


def _arguments(fmu: Opened, files: Any) -> tuple[list[str], list[str]]:
    """Return what one set of source files adds to the compiler's arguments, and the problems with it."""
    arguments: list[str] = []
    for name in files.includeDirectories:
        if _leaves(name):
            return [], [f"include directory {name!r} leaves the FMU"]
        arguments.append(f"-I{fmu.folder / 'sources' / name}")
    for definition in files.preprocessorDefinitions:
        value = definition.value or ""
        if not _C_WORD.fullmatch(definition.name or "") or not value.isprintable() or len(value) > 1000:
            return [], [f"preprocessor definition {definition.name!r} is not a name in C"]
        arguments.append(f"-D{definition.name}={value}" if definition.value is not None else f"-D{definition.name}")
    for name in files.sourceFiles:
        if _leaves(name):
            return [], [f"source file {name!r} leaves the FMU"]
        if f"sources/{name}" not in fmu.files:
            return [], [f"source file {name!r} is not in the archive"]
        arguments.append(str(fmu.folder / "sources" / name))
    return arguments, []


def _leaves(name: str) -> bool:
    path = PurePosixPath(name.replace("\\", "/"))
    return path.is_absolute() or ".." in path.parts or ":" in name or name.startswith("-")


def _build(fmu: Opened, arguments: list[str], target: Path) -> tuple[list[str], list[str]]:
    headers = Path(fmpy.__file__).parent / "c-code"  # importers bring FMI's headers where the FMU does not
    command = [
        *(sys.executable, "-m", "ziglang", "cc", "-std=c99", "-O1", "-w", "-fPIC", "-shared", "-ffp-contract=off"),
        *(f"-I{fmu.folder / 'sources'}", *arguments, f"-I{headers}", "-o", str(target)),
        *(() if platform.system() == "Windows" else ("-lm",)),
    ]
    surroundings = {**os.environ, "ZIG_LOCAL_CACHE_DIR": str(target.parent / "zig")}
    try:
        done = subprocess.run(
            command, stdin=subprocess.DEVNULL, capture_output=True, timeout=_LONGEST_BUILD, check=False,
            cwd=target.parent, env=surroundings,
            preexec_fn=None if platform.system() == "Windows" else _limit,
        )  # fmt: skip
    except (OSError, subprocess.TimeoutExpired) as error:
        return [], [f"build of the sources: the compiler could not be run ({error})"]
    if done.returncode != 0:
        return [f"the sources do not build: {_first_error(done.stderr, fmu.folder)}"], []
    with target.open("rb") as stream:
        data = stream.read()
    lacks = [name for name in header_functions(fmu.version) if name.encode() + b"\0" not in data] if fmu.ours else []
    return [f"the library built from the sources lacks {lacks[0]}"] if lacks else [], []


def _limit() -> None:
    """Bound what the compiler may take: macros and includes from someone else can ask for anything."""
    import resource

    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (_LONGEST_COMPUTING, _LONGEST_COMPUTING + 1))
    resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 28, 1 << 28))


def _first_error(text: bytes, folder: Path) -> str:
    lines = [line for line in text.decode("utf-8", "replace").splitlines() if "error" in line] or ["no message"]
    return lines[0].replace(str(folder) + "/", "")[:200]
