"""Build an FMU's binaries for every platform from one machine, with the compiler that comes with ziglang."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path

from stribeck.compiler import cache_folder
from stribeck.errors import InputError, StribeckError

FLAGS = (
    "-std=c99", "-O2", "-g0", "-ffp-contract=off", "-fno-math-errno", "-fvisibility=hidden", "-fno-unroll-loops",
    "-fno-vectorize", "-fno-slp-vectorize", "-fno-sanitize=undefined", "-fno-stack-protector", "-Wno-everything",
)  # fmt: skip
_LONGEST_BUILD = 900.0  # s; the first build of a target also builds its C library


@dataclass(frozen=True)
class Platform:
    """One platform that an FMU runs on.

    Attributes
    ----------
    name : str
        As FMI 3 names its folder: ``x86_64-linux``.
    target : str
        As zig names it. The C library of Linux is one that any system of the last ten years has.
    suffix : str
    fmi2 : str
        Folder in an FMI 2 archive, where the standard has one, which macOS's processors share; else FMI 3's name, as
        FMPy and the Reference FMUs do.
    compile, link : tuple of str
        Further arguments of the two steps.
    """

    name: str
    target: str
    suffix: str
    fmi2: str
    compile: tuple[str, ...]
    link: tuple[str, ...]


_UNIX = ("-fPIC",)
_LINUX = (_UNIX, ("-lm", "-Wl,-soname,{name}"))
_DARWIN = (_UNIX, ("-Wl,-install_name,@rpath/{name}",))
# no start-up code of MinGW's, which is larger than the model (c/bare.h); its library has no function sincos
_WINDOWS = (("-DFM_BARE", "-fno-builtin"), ("-nostdlib", "-lucrtbase"))
PLATFORMS: tuple[Platform, ...] = (
    Platform("x86_64-linux", "x86_64-linux-gnu.2.17", ".so", "linux64", *_LINUX),
    Platform("aarch64-linux", "aarch64-linux-gnu.2.17", ".so", "aarch64-linux", *_LINUX),
    Platform("x86_64-windows", "x86_64-windows-gnu", ".dll", "win64", *_WINDOWS),
    Platform("x86-windows", "x86-windows-gnu", ".dll", "win32", *_WINDOWS),
    Platform("aarch64-windows", "aarch64-windows-gnu", ".dll", "aarch64-windows", *_WINDOWS),
    Platform("x86_64-darwin", "x86_64-macos", ".dylib", "darwin64", *_DARWIN),
    Platform("aarch64-darwin", "aarch64-macos", ".dylib", "darwin64", *_DARWIN),
)


def platforms_named(names: Sequence[str] | None) -> tuple[Platform, ...]:
    """Return platforms by name, all where None; raise `InputError` for one that is not known."""
    if names is None:
        return PLATFORMS
    known = {platform.name: platform for platform in PLATFORMS}
    for name in names:
        if name not in known:
            raise InputError("unknown platform", name, f"use some of: {', '.join(known)}")
    if not names:
        raise InputError("no platform is named", "", f"use some of: {', '.join(known)}")
    return tuple(known[name] for name in dict.fromkeys(names))


def binary(sources: Mapping[str, str], main: str, identifier: str, platform: Platform) -> bytes:
    """Return the shared library of an FMU's sources for one platform, from the user's cache where it was built before.

    Parameters
    ----------
    sources : mapping of str to str
        File names and their text.
    main : str
        The file to compile; it includes the others.
    identifier : str
        The model identifier, which names the library.
    platform : Platform
        That it is to run on.
    """
    name = identifier + platform.suffix
    steps = [*FLAGS, *platform.compile, "/", *(flag.format(name=name) for flag in platform.link)]
    text = [f"{file}\0{sources[file]}" for file in sorted(sources)]
    key = hashlib.sha256("\0".join([*text, main, platform.target, *steps, _zig_version()]).encode()).hexdigest()[:32]
    folder = cache_folder() / "fmu"
    folder.mkdir(exist_ok=True, mode=0o700)
    kept = folder / f"{key}{platform.suffix}"
    if not kept.exists():
        with tempfile.TemporaryDirectory(prefix="build.", dir=folder) as part:
            made = _make(sources, main, name, platform, Path(part))
            made.write_bytes(_undated(made.read_bytes()))
            made.replace(kept)
    return kept.read_bytes()


def _make(sources: Mapping[str, str], main: str, name: str, platform: Platform, folder: Path) -> Path:
    work = folder / "sources"
    work.mkdir()
    for file, text in sources.items():
        (work / file).write_text(text, encoding="utf-8", newline="\n")
    link = [flag.format(name=name) for flag in platform.link]
    _zig([*FLAGS, *platform.compile, "-c", "-o", "model.o", main], platform, work)
    _zig(["-shared", "-s", "-o", name, "model.o", *link], platform, work)
    return work / name


def _undated(data: bytes) -> bytes:
    """Return a binary without the time of its linking, which Windows' format carries and zig cannot leave out."""
    if data[:2] != b"MZ":
        return data
    at = int.from_bytes(data[0x3C:0x40], "little") + 8  # of the COFF header's TimeDateStamp
    return data[:at] + bytes(4) + data[at + 4 :]


def _zig(arguments: list[str], platform: Platform, work: Path) -> None:
    command = [sys.executable, "-m", "ziglang", "cc", "-target", platform.target, *arguments]
    # relative names and a local cache of its own: nothing of this machine's folders gets into the binary
    environment = {**os.environ, "ZIG_LOCAL_CACHE_DIR": str(work.parent / "zig")}
    try:
        done = subprocess.run(
            command, cwd=work, env=environment, capture_output=True, text=True, timeout=_LONGEST_BUILD, check=False
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise StribeckError("zig could not be run", str(error), "install it: pip install ziglang") from error
    if done.returncode != 0:
        raise StribeckError(f"zig failed to build for {platform.name}", _first_error(done.stderr), "report this")


@cache
def _zig_version() -> str:
    return version("ziglang")


def _first_error(text: str) -> str:
    lines = [line for line in text.splitlines() if "error" in line]
    return (lines or text.splitlines() or ["no message"])[0]
