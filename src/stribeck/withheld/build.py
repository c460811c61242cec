"""Compile the plant once with the machine's C compiler and load it."""

from __future__ import annotations

import ctypes
from functools import cache
from importlib.resources import files

from stribeck.compiler import build, load

PARTS = ("fields.h", "tree.h", "friction.h", "drive.h", "stepper.h", "plant.c")  # each after what it includes


@cache
def library() -> ctypes.CDLL:
    """Return the compiled plant; the compiler runs only when source, flags or compiler are new to this user."""
    lib = load(build(_source(), level="-O2"))
    array, integer = ctypes.c_void_p, ctypes.c_int
    lib.plant_record.argtypes = [array, array, *[integer] * 4, ctypes.c_double, *[array] * 11]
    lib.plant_record.restype = integer
    lib.plant_inverse.argtypes = [array, array, integer, integer, *[array] * 4]
    lib.plant_inverse.restype = None
    for name in ("plant_joint_fields", "plant_world_fields"):
        getattr(lib, name).argtypes, getattr(lib, name).restype = [], ctypes.c_char_p
    lib.plant_truth_width.argtypes, lib.plant_truth_width.restype = [], integer
    return lib


def _source() -> str:
    """Return all parts in one text, so that none is looked for in a folder."""
    folder = files("stribeck.withheld") / "c"
    lines = "\n".join((folder / name).read_text(encoding="utf-8") for name in PARTS).splitlines()
    return "\n".join(line for line in lines if not line.startswith('#include "')) + "\n"
