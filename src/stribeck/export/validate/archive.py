"""Open an archive from someone else: bounded in size and memory, and no entry leaves the folder it is unpacked into."""

from __future__ import annotations

import os
import stat
import struct
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from typing import BinaryIO, Never

from stribeck.errors import InputError
from stribeck.textfile import explain_unreadable

MIB = 1 << 20
LARGEST_FILE = 256 * MIB
LARGEST_DIRECTORY = 4 * MIB  # of the archive's list of entries, which is read into memory whole
LARGEST_UNPACKED = 1024 * MIB
METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)  # that FMI allows
_LONGEST_NAME = 500
_CHUNK = MIB
_END, _END64 = b"PK\5\6", b"PK\6\7"
_LONGEST_END = (1 << 16) + 64  # bytes: the closing record, its comment, and what may stand before it


@contextmanager
def open_archive(path: Path) -> Iterator[zipfile.ZipFile]:
    """Open a zip archive and check its list of entries.

    Parameters
    ----------
    path : path

    Raises
    ------
    InputError
        When it cannot be read, is no zip archive, is absurdly large, or has an entry that would leave the folder into
        which it is unpacked: an absolute path, ``..``, a link, or a file where another entry has a folder.
    """
    try:
        with path.open("rb") as stream:
            size = os.fstat(stream.fileno()).st_size
            if size > LARGEST_FILE:
                _refuse(path, "too large for an FMU", f"{size / MIB:.0f} MiB", f"at most {LARGEST_FILE // MIB} MiB")
            _check_end(path, stream, size)
            with zipfile.ZipFile(stream) as archive:
                _check_entries(path, archive.infolist())
                yield archive
    except OSError as error:
        raise explain_unreadable(path, error) from error
    except (zipfile.BadZipFile, NotImplementedError, struct.error, UnicodeDecodeError, EOFError) as error:
        raise InputError(f"{path}: not a sound zip archive", str(error), "export the FMU again") from error


def unpack(path: Path, archive: zipfile.ZipFile, folder: Path) -> None:
    """Unpack a checked archive into an existing folder, never more bytes than it declares."""
    left = LARGEST_UNPACKED
    for entry in archive.infolist():
        target = folder.joinpath(*PurePosixPath(entry.filename).parts)
        if entry.is_dir():
            target.mkdir(parents=True, exist_ok=True)
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        try:
            with archive.open(entry) as source, target.open("xb") as out:
                while chunk := source.read(_CHUNK):
                    left -= len(chunk)
                    if left < 0:
                        _refuse(path, "unpacks to too much", f"over {LARGEST_UNPACKED // MIB} MiB", "give a real FMU")
                    out.write(chunk)
        except (zlib.error, RuntimeError) as error:  # RuntimeError is zipfile's for a password
            raise InputError(f"{path}: {entry.filename} cannot be unpacked", str(error), "export it again") from error


def _check_end(path: Path, stream: BinaryIO, size: int) -> None:
    """Check the record that closes the archive: zipfile would read a directory of any size into memory."""
    stream.seek(max(0, size - _LONGEST_END))
    tail = stream.read()
    at = tail.rfind(_END)
    if at < 0 or len(tail) - at < 22:
        _refuse(path, "not an FMU", "no zip archive", "give the path of a .fmu file")
    (directory,) = struct.unpack_from("<I", tail, at + 12)
    if _END64 in tail[max(0, at - 20) : at]:
        _refuse(path, "not an FMU that can be checked", "a zip64 archive", "pack it as a plain zip archive")
    if directory > LARGEST_DIRECTORY:
        found = f"a list of entries of {directory / MIB:.0f} MiB"
        _refuse(path, "has too many files for an FMU", found, f"at most {LARGEST_DIRECTORY // MIB} MiB")


def _check_entries(path: Path, entries: list[zipfile.ZipInfo]) -> None:
    total = sum(entry.file_size for entry in entries)
    if total > LARGEST_UNPACKED:
        found = f"{total / MIB:.0f} MiB"
        _refuse(path, "unpacks to too much for an FMU", found, f"at most {LARGEST_UNPACKED // MIB} MiB")
    files: set[str] = set()
    for entry in entries:
        fault = _fault(entry)
        if fault:
            _refuse(path, f"entry {_shown(entry.orig_filename)} {fault}", "", "do not trust this file")
        if entry.compress_type not in METHODS:  # of others Python unpacks whole stretches, however large
            found = f"method {entry.compress_type}"
            _refuse(path, f"entry {_shown(entry.filename)} is packed in no usual way", found, "pack it by deflate")
        if entry.flag_bits & 0x1:
            _refuse(path, f"entry {_shown(entry.filename)} is encrypted", "", "pack the FMU without a password")
        if not entry.is_dir():
            key = entry.filename.casefold()
            if key in files:
                _refuse(path, "has two entries of one name", _shown(entry.filename), "export the FMU again")
            files.add(key)
    for name in files:
        for parent in PurePosixPath(name).parents:
            if str(parent) in files:
                _refuse(path, "has a file where another entry has a folder", _shown(str(parent)), "export it again")


def _fault(entry: zipfile.ZipInfo) -> str:
    """Say in words how an entry would leave its folder; empty where it does not."""
    name = entry.orig_filename
    parts = name.replace("\\", "/").split("/")
    kind = stat.S_IFMT(entry.external_attr >> 16)
    if name.startswith(("/", "\\")) or ":" in parts[0]:
        return "has an absolute path"
    if ".." in parts:
        return "leaves the archive with '..'"
    if "\0" in name or not name:
        return "has no proper name"
    if kind and not (stat.S_ISREG(kind) or stat.S_ISDIR(kind)):
        return "is a link or a device"
    return "has an absurdly long name" if len(name) > _LONGEST_NAME else ""


def _shown(name: str) -> str:
    return repr(name if len(name) <= 80 else name[:77] + "...")


def _refuse(path: Path, what: str, found: str, do: str) -> Never:
    raise InputError(f"{path}: {what}", found, do)
