"""An FMU's archive: the same content gives the same bytes."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from pathlib import Path

from stribeck.outputs import whole_file

_EPOCH = (1980, 1, 1, 0, 0, 0)  # the earliest date that a ZIP file can carry
_READABLE, _REGULAR, _UNIX = 0o644, 0o100000, 3


def write_archive(files: Mapping[str, bytes | str], path: Path) -> None:
    """Write a ZIP file whose bytes depend on the content alone: sorted names, one date, one mode.

    Parameters
    ----------
    files : mapping of str to bytes or str
        Content by name with forward slashes; text is written in UTF-8.
    path : path
        Replaced when it exists; written whole or not at all.
    """
    order = sorted(files, key=lambda name: (name != "modelDescription.xml", name))  # what readers want first
    with whole_file(path) as part, zipfile.ZipFile(part, "w") as archive:
        for name in order:
            content = files[name]
            entry = zipfile.ZipInfo(name, _EPOCH)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = _UNIX  # not the machine's own
            entry.external_attr = (_READABLE | _REGULAR) << 16
            data = content.encode("utf-8") if isinstance(content, str) else content
            archive.writestr(entry, data, compresslevel=9)
