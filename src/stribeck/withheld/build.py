"""Compile the plant once with the machine's C compiler and load it."""

from __future__ import annotations

import ctypes
import hashlib
import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path

from stribeck.errors import StribeckError

SOURCE = Path(__file__).parent / "c"
# No fast-math: a NaN must stay a NaN; no contraction: the same record on every machine with IEEE doubles.
FLAGS = ("-O2", "-std=c11", "-fPIC", "-shared", "-ffp-contract=off")


def compiler() -> tuple[str, ...]:
    """Return the command of the C compiler: the machine's ``cc`` or ``gcc`` or ``clang``, else the ziglang wheel."""
    for name in ("cc", "gcc", "clang"):
        path = shutil.which(name)
        if path:
            return (path,)
    if importlib.util.find_spec("ziglang"):
        return (sys.executable, "-m", "ziglang", "cc")
    raise StribeckError("no C compiler for the recording plant", "", "install gcc or clang, or `pip install ziglang`")


@cache
def library() -> ctypes.CDLL:
    """Return the compiled plant; the compiler runs only when source, flags or compiler are new to this user."""
    command = compiler()
    files = sorted(SOURCE.glob("*.[ch]"))
    digest = hashlib.sha256(
        repr((command, FLAGS, sys.platform, os.uname().machine if hasattr(os, "uname") else "")).encode()
    )
    for file in files:
        digest.update(file.name.encode() + b"\0" + file.read_bytes())
    target = _cache_folder() / f"plant-{digest.hexdigest()[:24]}.so"
    if not target.exists():
        _compile(command, target)
    return _load(target)


def _cache_folder() -> Path:
    root = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA") or str(Path.home() / ".cache")
    folder = Path(root) / "stribeck" / "withheld"
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except OSError:  # a home that cannot be written: a private folder of this process instead
        return Path(tempfile.mkdtemp(prefix="stribeck-"))


def _compile(command: tuple[str, ...], target: Path) -> None:
    handle, name = tempfile.mkstemp(dir=target.parent, suffix=".so")
    os.close(handle)
    try:
        run = subprocess.run(
            [*command, *FLAGS, str(SOURCE / "plant.c"), "-o", name, "-lm"], capture_output=True, text=True, check=False
        )
        if run.returncode != 0:
            raise StribeckError("the recording plant does not compile", run.stderr, "check the C compiler")
        os.replace(name, target)  # whole or not at all: two processes may build at the same time
    finally:
        Path(name).unlink(missing_ok=True)


def _load(path: Path) -> ctypes.CDLL:
    lib = ctypes.CDLL(str(path))
    array, integer = ctypes.c_void_p, ctypes.c_int
    lib.plant_record.argtypes = [array, array, *[integer] * 4, ctypes.c_double, *[array] * 11]
    lib.plant_record.restype = integer
    lib.plant_inverse.argtypes = [array, array, integer, integer, *[array] * 4]
    lib.plant_inverse.restype = None
    for name in ("plant_joint_fields", "plant_world_fields"):
        getattr(lib, name).argtypes, getattr(lib, name).restype = [], ctypes.c_char_p
    lib.plant_truth_width.argtypes, lib.plant_truth_width.restype = [], integer
    return lib
