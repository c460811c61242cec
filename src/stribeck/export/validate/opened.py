"""An FMU unpacked into a folder of its own for as long as it is looked at."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.parsers import expat

from fmpy import read_model_description

from stribeck.errors import InputError
from stribeck.export.validate.archive import open_archive, unpack
from stribeck.export.validate.markup import check_markup

DESCRIPTION = "modelDescription.xml"
ARM = "resources/arm.toml"
MOST_VARIABLES = 20_000
_LONGEST_NAME = 1000  # of a variable: the time that checking a name takes grows faster than its length


@dataclass(frozen=True)
class Opened:
    """An unpacked FMU.

    Attributes
    ----------
    source : str
        Its path, for messages.
    folder : path
        Where it is unpacked.
    files : tuple of str
        Paths of its files, ``/`` between folders.
    description : fmpy.model_description.ModelDescription or None
        None where fmpy cannot make sense of it; then ``problems`` says why.
    problems : tuple of str
        What fmpy's validation finds.
    """

    source: str
    folder: Path
    files: tuple[str, ...]
    description: Any
    problems: tuple[str, ...]

    @property
    def version(self) -> int:
        """Major version of FMI."""
        return int(self.description.fmiMajorVersion)

    @property
    def kinds(self) -> dict[str, str]:
        """Interface type -> model identifier, of those that can be simulated."""
        found = {"CoSimulation": self.description.coSimulation, "ModelExchange": self.description.modelExchange}
        return {kind: entry.modelIdentifier for kind, entry in found.items() if entry is not None}

    @property
    def ours(self) -> bool:
        """Whether it says that it holds an arm of this package."""
        return ARM in self.files

    def inside(self, text: str) -> str:
        """Return a message with the paths of its files as they are in the FMU."""
        return text.replace(f"{self.folder}/", "")


@contextmanager
def opened(path: Path | str) -> Iterator[Opened]:
    """Unpack an FMU and read its description.

    Parameters
    ----------
    path : path

    Raises
    ------
    InputError
        When the file is no FMU, or one that should not be touched (see `stribeck.export.validate.archive` and
        `stribeck.export.validate.markup`).
    """
    path = Path(path)
    with tempfile.TemporaryDirectory(prefix="stribeck.fmu.") as name:
        folder = Path(name)
        with open_archive(path) as archive:  # what fails later is no fault of the archive's
            files = tuple(entry.filename for entry in archive.infolist() if not entry.is_dir())
            if DESCRIPTION not in files:
                do = "give the path of a .fmu file"
                raise InputError(f"{path}: not an FMU", f"no {DESCRIPTION} in the archive", do)
            unpack(path, archive, folder)
        check_markup(folder, [file for file in files if file.endswith(".xml")], str(path))
        _check_root(folder / DESCRIPTION, f"{path}: {DESCRIPTION}")
        description, problems = _described(folder)
        backslashes = [f"the path {file!r} has a backslash" for file in files if "\\" in file]
        yield Opened(str(path), folder, files, description, (*backslashes, *problems))


def _check_root(file: Path, where: str) -> None:
    parser, names, long = expat.ParserCreate(), [], []

    def start(name: str, attributes: dict[str, str]) -> None:
        names.append(name)
        if len(attributes.get("name", "")) > _LONGEST_NAME:
            long.append(name)

    parser.StartElementHandler = start
    with file.open("rb") as stream:
        parser.ParseFile(stream)
    if names[0] != "fmiModelDescription":
        raise InputError(f"{where} describes no FMU", f"<{names[0][:60]}>", "give the path of a .fmu file")
    if long:
        raise InputError(f"{where} has an absurdly long name", f"over {_LONGEST_NAME} characters", "shorten it")
    if len(names) > 10 * MOST_VARIABLES:
        raise InputError(f"{where} is too large to be checked", f"{len(names)} elements", "check a smaller FMU")


def _described(folder: Path) -> tuple[Any, list[str]]:
    """Return the description, None where it makes no sense, and the problems that fmpy finds in it."""
    problems: list[str] = []
    description = None
    try:
        read_model_description(str(folder), validate_variable_names=True, validate_model_structure=True)
    except Exception as error:
        # fmpy raises whatever a malformed description makes it stumble over
        problems = list(getattr(error, "problems", [])) or [f"modelDescription.xml: {error or type(error).__name__}"]
    try:
        description = read_model_description(str(folder), validate=False)
        problems += [
            f"modelIdentifier {name!r} is not a name in C"
            for name in {part.modelIdentifier for part in (description.coSimulation, description.modelExchange) if part}
            if not re.fullmatch(r"[A-Za-z_]\w{0,199}", str(name), re.ASCII)
        ]
    except Exception as error:
        problems = problems or [f"modelDescription.xml: {error or type(error).__name__}"]
    if any("is not a name in C" in problem for problem in problems):
        description = None  # a path is made of it
    return description, [" ".join(str(problem).split())[:300] for problem in problems]
