"""Build a C source once per user: the machine's compiler, else the one that comes with ziglang."""

from __future__ import annotations

import ctypes
import hashlib
import os
import platform
import shutil
import stat
import subprocess
import sys
import tempfile
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from stribeck.errors import StribeckError

FLAGS = ("-std=c99", "-ffp-contract=off", "-fno-math-errno", "-fPIC", "-shared")
_LONGEST_BUILD = 600.0  # s


@cache
def compiler() -> tuple[str, ...]:
    """Return the command of a C compiler: ``STRIBECK_CC``, cc, gcc, clang, else zig."""
    chosen = os.environ.get("STRIBECK_CC")
    if chosen:
        return tuple(chosen.split())
    for name in ("cc", "gcc", "clang"):
        found = shutil.which(name)
        if found:
            return (found,)
    if find_spec("ziglang"):
        return (sys.executable, "-m", "ziglang", "cc")
    raise StribeckError("no C compiler", "", "install gcc, or: pip install ziglang")


@cache
def _identity(command: tuple[str, ...]) -> str:
    machine = f"{sys.platform} {platform.machine()}"  # a home may be shared by machines of several kinds
    return "\0".join([*command, machine, _call([*command, "--version"]).stdout])


def _call(command: list[str]) -> subprocess.CompletedProcess[str]:
    try:
        return subprocess.run(command, capture_output=True, text=True, timeout=_LONGEST_BUILD, check=False)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise StribeckError("the C compiler could not be run", str(error), "check STRIBECK_CC") from error


def cache_folder() -> Path:
    """Return a folder for compiled code of the user's own, made where missing; nobody else may write to it.

    ``STRIBECK_CACHE``, else the user's cache, else, where no home can be written, one beside the temporary files.

    Raises
    ------
    StribeckError
        The folder cannot be written, or others could put code there.
    """
    chosen = os.environ.get("STRIBECK_CACHE")
    if chosen is not None:
        folders = [Path(chosen)]
    else:
        home = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA") or str(Path.home() / ".cache")
        spare = f"stribeck-{os.getuid()}" if hasattr(os, "getuid") else "stribeck"
        folders = [Path(home) / "stribeck", Path(tempfile.gettempdir()) / spare]
    folder = next((folder for folder in folders if _writable(folder)), None)
    if folder is None:
        raise StribeckError("no folder for compiled code can be written", str(folders[0]), "set STRIBECK_CACHE to one")
    if hasattr(os, "getuid"):
        status = folder.stat()
        if status.st_uid != os.getuid() or status.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
            what = f"{folder}: the cache of compiled code must be the user's own and closed to others"
            raise StribeckError(what, do="set STRIBECK_CACHE to another folder")
    return folder


def _writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def build(source: str, folder: Path | None = None, *, level: str = "-O1") -> Path:
    """Return the shared library of a C source, built unless it is in the cache.

    Parameters
    ----------
    source : str
        The whole translation unit.
    folder : path or None
        Where to keep it; the user's cache where None.
    level : str
        Of optimisation. Of a model's equations more makes nothing faster but the wait for them longer.

    Notes
    -----
    The name is a digest of source, flags and compiler. A build is moved to its name in one step, so that processes
    may build side by side.
    """
    command = compiler()
    key = hashlib.sha256("\0".join([source, *FLAGS, level, _identity(command)]).encode()).hexdigest()[:32]
    kept = folder if folder is not None else cache_folder()
    target = kept / f"{key}.so"
    if target.exists():
        return target
    with tempfile.TemporaryDirectory(prefix="build.", dir=kept) as name:
        work = Path(name)
        (work / "model.c").write_text(source, encoding="utf-8")
        call = [*command, *FLAGS, level, "-o", str(work / "model.so"), str(work / "model.c"), "-lm"]
        done = _call(call)
        if done.returncode != 0:
            raise StribeckError("the C compiler failed", done.stderr.strip()[:150], "check STRIBECK_CC")
        (work / "model.so").replace(target)
    return target


@cache
def load(path: Path) -> ctypes.CDLL:
    """Return the loaded library; calls into it release the interpreter's lock."""
    return ctypes.CDLL(str(path))
