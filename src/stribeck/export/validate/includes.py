"""Whether sources would make a compiler read what lies outside their FMU: a device that never ends, say."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from typing import Any

from stribeck.export.validate.opened import Opened

# As a compiler reads it: a hash that only blanks or a comment come before on its line.
_HASH = rb"(?:^|\*/)[ \t\f\v]*(?:#|%:)[ \t\f\v]*"
_INCLUDE = re.compile(_HASH + rb"(include(?:_next)?|import|__include_macros)\b[ \t\f\v]*(.{0,500})", re.MULTILINE)
_NAME = re.compile(rb"""["<]([^">]+)[">]""")
_OTHER = (
    (re.compile(_HASH + rb"/[*/]", re.MULTILINE), "hides what it asks the preprocessor for behind a comment"),
    (re.compile(_HASH + rb"embed\b|\b__has_embed\b", re.MULTILINE), "embeds a file"),
    (re.compile(rb"\.inc(?:bin|lude)\b"), "includes a file by assembler"),
)


def outside(fmu: Opened, sets: Sequence[Any]) -> str:
    """Return what a source would read from outside its FMU, or read so that it cannot be told; empty where none does.

    A source can still put such a request together from parts, so that this is no reason to trust one.

    Parameters
    ----------
    fmu : Opened
    sets : sequence of fmpy.model_description.SourceFileSet
        What is compiled, and the directories in which the compiler looks for what that includes.
    """
    held = {file.lower(): file for file in fmu.files}  # some file systems take either case
    directories = ["sources", *(f"sources/{name}" for files in sets for name in files.includeDirectories)]
    waiting = [
        name for files in sets for name in (f"sources/{file}" for file in files.sourceFiles) if name in fmu.files
    ]
    seen = set(waiting)
    while waiting:
        file = waiting.pop()
        text = _joined((fmu.folder / file).read_bytes())
        for pattern, does in _OTHER:
            if pattern.search(text):
                return f"{file} {does}"
        for word, argument in _INCLUDE.findall(text):
            found = _NAME.match(argument)
            if found is None:
                return f"{file} includes {_shown(argument)!r}, which is no plain name of a file"
            name = found[1].decode("utf-8", "replace").replace("\\", "/")
            targets = [os.path.normpath(f"{place}/{name}") for place in (os.path.dirname(file), *directories)]
            if word == b"include" and argument.startswith(b'"') and targets[0] in fmu.files:
                del targets[1:]  # the compiler looks beside the file first
            if name.startswith("/") or ":" in name or any(target.startswith("..") for target in targets):
                return f"{file} includes {name[:80]!r}, which leaves the FMU"
            further = {held[target.lower()] for target in targets if target.lower() in held} - seen
            waiting += sorted(further)
            seen |= further
    return ""


def _joined(text: bytes) -> bytes:
    """Return a source as a compiler reads it: trigraphs replaced, lines joined that a backslash continues."""
    text = text.removeprefix(b"\xef\xbb\xbf").replace(b"\0", b" ").replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    text = text.replace(b"??=", b"#").replace(b"??/", b"\\")
    return re.sub(rb"\\[ \t\f\v]*\n", b"", text)


def _shown(argument: bytes) -> str:
    return " ".join(argument.decode("utf-8", "replace").split())[:80]
