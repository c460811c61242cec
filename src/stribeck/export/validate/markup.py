"""Look at XML from someone else before any other parser does: no entities, no depth, no size beyond reason."""

from __future__ import annotations

from pathlib import Path
from xml.parsers import expat

from stribeck.errors import InputError

LARGEST = 16 << 20  # bytes; a parsed tree takes some twenty times as much memory
MOST_ELEMENTS = 500_000
DEEPEST = 100
MOST_ATTRIBUTES = 200
LONGEST_ATTRIBUTE = 1 << 16


class _Stop(Exception):
    pass


def check_markup(folder: Path, names: list[str], source: str) -> None:
    """Check the XML files of an unpacked FMU.

    Parameters
    ----------
    folder : path
    names : list of str
        Paths in ``folder`` of the files that some parser will read.
    source : str
        The FMU, for the message.

    Raises
    ------
    InputError
        For a document type declaration, which is where entities are declared (FMI has no use for one), for a file that
        is not well-formed, and for absurd sizes.
    """
    for name in names:
        _check(folder / name, f"{source}: {name}")


def _check(path: Path, where: str) -> None:
    size = path.stat().st_size
    if size > LARGEST:
        raise InputError(f"{where} is too large", f"{size >> 20} MiB", f"at most {LARGEST >> 20} MiB are read")
    parser = expat.ParserCreate()
    count = depth = 0

    def start(_: str, attributes: dict[str, str]) -> None:
        nonlocal count, depth
        count, depth = count + 1, depth + 1
        if count > MOST_ELEMENTS:
            raise _Stop("has too many elements", f"more than {MOST_ELEMENTS}")
        if depth > DEEPEST:
            raise _Stop("is nested too deeply", f"more than {DEEPEST} levels")
        if len(attributes) > MOST_ATTRIBUTES or any(len(value) > LONGEST_ATTRIBUTE for value in attributes.values()):
            raise _Stop("has an absurd attribute", "")

    def end(_: str) -> None:
        nonlocal depth
        depth -= 1

    def doctype(*_: object) -> None:
        raise _Stop("declares a document type, which could hide entities", "<!DOCTYPE")

    # stops at the declaration itself, before the first entity is read
    parser.StartDoctypeDeclHandler, parser.StartElementHandler, parser.EndElementHandler = doctype, start, end
    try:
        with path.open("rb") as stream:
            parser.ParseFile(stream)
    except _Stop as stop:
        raise InputError(f"{where} {stop.args[0]}", stop.args[1], "do not trust this file") from stop
    except (expat.ExpatError, ValueError, LookupError) as error:
        raise InputError(f"{where} is not well-formed XML", str(error), "export the FMU again") from error
