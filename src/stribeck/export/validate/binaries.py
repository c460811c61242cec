"""The binaries of an FMU: in the right folders, for the platform that the folder names, with every function of FMI."""

from __future__ import annotations

import mmap
import re
import struct
from functools import cache
from pathlib import Path

import fmpy

from stribeck.export.validate.opened import Opened

OLDEST_GLIBC = 17  # minor version of glibc 2 that exports are built for
_SUFFIX = {"linux": ".so", "windows": ".dll", "darwin": ".dylib"}
_FOLDERS = {
    "linux64": ("x86_64", "linux"),
    "linux32": ("x86", "linux"),
    "win64": ("x86_64", "windows"),
    "win32": ("x86", "windows"),
    "darwin64": ("x86_64", "darwin"),
}
_ELF = {0x3E: "x86_64", 0xB7: "aarch64", 0x03: "x86"}
_PE = {0x8664: "x86_64", 0xAA64: "aarch64", 0x14C: "x86"}
_MACH = {0x01000007: "x86_64", 0x0100000C: "aarch64"}
# Functions that only one of the interface types needs; the rest of the header both do.
_EXCHANGE = re.compile(
    "fmi2(EnterEventMode|NewDiscreteStates|EnterContinuousTimeMode|CompletedIntegratorStep|SetTime|SetContinuousStates"
    "|GetDerivatives|GetEventIndicators|GetContinuousStates|GetNominalsOfContinuousStates)"
    "|fmi3(EnterContinuousTimeMode|CompletedIntegratorStep|SetTime|SetContinuousStates|GetContinuousStateDerivatives"
    "|GetEventIndicators|GetContinuousStates|GetNominalsOfContinuousStates|GetNumberOfEventIndicators"
    "|GetNumberOfContinuousStates)"
)
_STEPPING = re.compile(
    "fmi2(SetRealInputDerivatives|GetRealOutputDerivatives|DoStep|CancelStep|Get(Real|Integer|Boolean|String)?Status)"
    "|fmi3(EnterStepMode|GetOutputDerivatives|DoStep)"
)


def binary_problems(fmu: Opened) -> tuple[list[str], list[str]]:
    """Return the problems of all binaries, and what was not checked."""
    problems, skipped = [], []
    folders = sorted({file.split("/")[1] for file in fmu.files if re.fullmatch(r"binaries/[^/]+/[^/]+", file)})
    for name in folders:
        known = _platform(name)
        if known is None:
            skipped.append(f"binaries/{name}: not a platform that FMI names")
            continue
        for identifier in sorted(set(fmu.kinds.values())):
            file = f"binaries/{name}/{identifier}{_SUFFIX[known[1]]}"
            if file not in fmu.files:
                problems.append(f"{file} is missing")
            else:
                problems += _file_problems(fmu, file, *known)
    if not folders and not any(file.startswith("sources/") for file in fmu.files):
        problems.append("has neither binaries nor sources: nothing can run it")
    if fmu.version not in (2, 3):
        skipped.append(f"functions of FMI {fmu.description.fmiVersion}")
    return problems, skipped


def platform_folders(fmu: Opened) -> list[str]:
    """Return the names of the folders with binaries."""
    return sorted({file.split("/")[1] for file in fmu.files if file.startswith("binaries/") and file.count("/") == 2})


def _platform(folder: str) -> tuple[str, str] | None:
    if folder in _FOLDERS:
        return _FOLDERS[folder]
    match = re.fullmatch(r"(x86|x86_64|aarch64)-(linux|windows|darwin)", folder)
    return (match[1], match[2]) if match else None


def _file_problems(fmu: Opened, file: str, architecture: str, system: str) -> list[str]:
    path = fmu.folder / file
    if path.stat().st_size < 64:
        return [f"{file} is not a binary"]
    with path.open("rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
        found = _target(data)
        if found is None or found[0] != system or architecture not in found[1]:
            says = "something else" if found is None else f"{found[0]} on {' and '.join(found[1])}"
            return [f"{file} is built for {says}, not for {system} on {architecture}"]
        missing = [name for name in _functions(fmu) if data.find(name.encode() + b"\0") < 0]
        problems = [f"{file} lacks {', '.join(missing[:5])}" + (", ..." if len(missing) > 5 else "")] if missing else []
        glibc = max((int(match[1]) for match in re.finditer(rb"GLIBC_2\.(\d{1,3})", data)), default=0)
    if fmu.ours and glibc > OLDEST_GLIBC:
        problems.append(f"{file} needs glibc 2.{glibc}, newer than 2.{OLDEST_GLIBC}")
    return problems


def _target(data: mmap.mmap) -> tuple[str, list[str]] | None:
    """Return the system and the architectures that a binary is built for."""
    head = bytes(data[:4])
    if head == b"\x7fELF":
        (machine,) = struct.unpack_from("<H", data, 18)
        return "linux", [_ELF.get(machine, "another machine")]
    if head[:2] == b"MZ":
        (at,) = struct.unpack_from("<I", data, 60)
        if at + 6 > len(data) or bytes(data[at : at + 4]) != b"PE\0\0":
            return None
        (machine,) = struct.unpack_from("<H", data, at + 4)
        return "windows", [_PE.get(machine, "another machine")]
    if head == b"\xcf\xfa\xed\xfe":
        (machine,) = struct.unpack_from("<I", data, 4)
        return "darwin", [_MACH.get(machine, "another machine")]
    if head == b"\xca\xfe\xba\xbe":
        (count,) = struct.unpack_from(">I", data, 4)
        if not 0 < count <= 8 or 8 + 20 * count > len(data):
            return None
        machines = [struct.unpack_from(">I", data, 8 + 20 * i)[0] for i in range(count)]
        return "darwin", [_MACH.get(machine, "another machine") for machine in machines]
    return None


def _functions(fmu: Opened) -> list[str]:
    """Return the functions that a binary must export: all for our own, else those of its interface types."""
    if fmu.version not in (2, 3):
        return []
    names = header_functions(fmu.version)
    if fmu.ours:
        return list(names)
    lacks = []
    if "ModelExchange" not in fmu.kinds:
        lacks.append(_EXCHANGE)
    if "CoSimulation" not in fmu.kinds:
        lacks.append(_STEPPING)
    return [name for name in names if not any(pattern.fullmatch(name) for pattern in lacks)]


@cache
def header_functions(version: int) -> tuple[str, ...]:
    """Return the functions that the header of an FMI version declares."""
    text = (Path(fmpy.__file__).parent / "c-code" / f"fmi{version}Functions.h").read_text(encoding="utf-8")
    return tuple(re.findall(rf"FMI{version}_Export\s+\w+\s+(\w+)\s*;", text))
