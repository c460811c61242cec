"""Outputs that appear whole or not at all: written beside their place, moved there at the end."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from stribeck.errors import InputError
from stribeck.stopping import stop_if_asked


@contextmanager
def whole_folder(path: Path | str) -> Iterator[Path]:
    """Give a temporary folder beside `path` and move it to `path` when the block ends without an exception.

    Nothing is left behind when it ends with one, Ctrl-C included.

    Parameters
    ----------
    path : path
        The folder to make. It may exist when it is empty.

    Raises
    ------
    InputError
        Before the block runs, when `path` is a file or a folder that is not empty, or cannot be made.
    """
    path = Path(path)
    check_free(path)
    made = _make_parents(path)
    try:
        part = Path(tempfile.mkdtemp(prefix=f".{path.name}.", suffix=".part", dir=path.absolute().parent))
    except OSError as error:
        _remove_empty(made)
        raise _cannot_write(path, error) from error
    try:
        yield part
        stop_if_asked()
        part.chmod(0o777 & ~_umask())  # mkdtemp makes it private; the result should be as readable as any folder
        part.replace(path)
    except BaseException:
        shutil.rmtree(part, ignore_errors=True)
        _remove_empty(made)
        raise


@contextmanager
def whole_file(path: Path | str) -> Iterator[Path]:
    """Give a temporary path beside `path` and move it to `path` when the block ends without an exception.

    An existing file is replaced; nothing is left behind, and an existing file stays, when the block raises.

    Raises
    ------
    InputError
        Before the block runs, when `path` is a folder or its folder cannot be written.
    """
    path = Path(path)
    if path.is_dir():
        raise InputError(f"{path}: cannot be written", "a folder", "give the name of a file")
    made = _make_parents(path)
    try:
        handle, name = tempfile.mkstemp(prefix=f".{path.name}.", suffix=".part", dir=path.absolute().parent)
    except OSError as error:
        _remove_empty(made)
        raise _cannot_write(path, error) from error
    os.close(handle)
    part = Path(name)
    try:
        yield part
        stop_if_asked()
        part.chmod(0o666 & ~_umask())
        part.replace(path)
    except BaseException:
        part.unlink(missing_ok=True)
        _remove_empty(made)
        raise


def check_free(path: Path | str) -> None:
    """Raise `InputError` unless `path` does not exist yet or is an empty folder."""
    path = Path(path)
    try:
        if path.is_dir():
            if any(path.iterdir()):
                raise InputError(
                    f"{path}: output folder is not empty", "", "give a new folder, or remove this one first"
                )
        elif path.exists() or path.is_symlink():
            raise InputError(f"{path}: output folder cannot be made", "a file of that name", "give a new folder")
    except OSError as error:
        raise _cannot_write(path, error) from error


def _make_parents(path: Path) -> list[Path]:
    """Make the missing parent folders of `path`; return those made, deepest first."""
    missing = [folder for folder in path.absolute().parents if not folder.exists()]
    try:
        path.absolute().parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        _remove_empty(missing)
        raise _cannot_write(path, error) from error
    return missing


def _remove_empty(folders: list[Path]) -> None:
    for folder in folders:
        try:
            folder.rmdir()
        except OSError:  # something else is in it by now, so it stays
            return


def _cannot_write(path: Path, error: OSError) -> InputError:
    return InputError(f"{path}: cannot be written", (error.strerror or str(error)).lower(), "give another place")


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
