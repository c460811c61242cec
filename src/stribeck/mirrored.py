"""Structures and names that are written twice, in C and in Python: compared once the library is loaded.

A library exports the fields of a structure as ``<name>_fields`` (their declarations, each closed by a semicolon) and
its size as ``<name>_size``; names that Python counts from 0 are exported as ``<name>_names``, each closed likewise.
"""

from __future__ import annotations

import ctypes
import re
from collections.abc import Sequence
from itertools import zip_longest

import numpy as np

from stribeck.errors import StribeckError

_DO = "write them alike in the C source and in Python"


def check_structure(library: ctypes.CDLL, name: str, mirror: type[ctypes.Structure] | np.dtype) -> None:
    """Raise `StribeckError` where a library's structure and its mirror differ in the order of fields, or in size.

    Parameters
    ----------
    library : CDLL
    name : str
        Of the structure in C.
    mirror : type or dtype
        Of the structure, or of the records, in Python.
    """
    if isinstance(mirror, np.dtype):
        ours, size = tuple(mirror.names or ()), mirror.itemsize
    else:
        ours, size = tuple(field[0] for field in mirror._fields_), ctypes.sizeof(mirror)
    _compare(f"the fields of {name}", _told(library, f"{name}_fields"), ours)
    tell = getattr(library, f"{name}_size")
    tell.argtypes, tell.restype = [], ctypes.c_longlong
    if tell() != size:
        raise StribeckError(f"the size of {name} differs", f"{tell()} bytes in C, {size} in Python", _DO)


def check_names(library: ctypes.CDLL, name: str, mirror: Sequence[str]) -> None:
    """Raise `StribeckError` where names that Python counts stand in another order in the library.

    Parameters
    ----------
    library : CDLL
    name : str
        Of the list in C, whose names are those of Python in capitals.
    mirror : sequence of str
    """
    _compare(name, tuple(told.lower() for told in _told(library, f"{name}_names")), tuple(mirror))


def _told(library: ctypes.CDLL, function: str) -> tuple[str, ...]:
    """Return the last word of each declaration, without its square brackets."""
    tell = getattr(library, function)
    tell.argtypes, tell.restype = [], ctypes.c_char_p
    return tuple(re.findall(r"(\w+)(?:\[\w+\])*;", tell().decode()))


def _compare(what: str, theirs: tuple[str, ...], ours: tuple[str, ...]) -> None:
    for place, (their, our) in enumerate(zip_longest(theirs, ours, fillvalue="nothing")):
        if their != our:
            raise StribeckError(f"{what} differ at place {place}", f"{their} in C, {our} in Python", _DO)
