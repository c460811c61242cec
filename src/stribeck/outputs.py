"""Outputs that appear whole or not at all: written beside their place, moved there at the end."""

from __future__ import annotations

import errno
import os
import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from stribeck.errors import InputError
from stribeck.stopping import stop_if_asked

FULL = (errno.ENOSPC, errno.EDQUOT)  # the disk, or the user's part of it


@contextmanager
def whole_folder(path: Path | str) -> Iterator[Path]:
    """Give a temporary folder beside `path` and move it to `path` when the block ends without an exception.

    Nothing is left behind when it ends with one, Ctrl-C included.

    Parameters
    ----------
    path : path
        The folder to make. It may exist when it is empty, and be a link to such a one.

    Raises
    ------
    InputError
        Before the block runs, when `path` is a file or a folder that is not empty, or cannot be made. At its end, when
        someone else has written there meanwhile, or the disk is full.
    """
    path = Path(path)
    check_free(path)
    with _part(path, tempfile.mkdtemp, 0o777) as part:
        yield part


@contextmanager
def whole_file(path: Path | str) -> Iterator[Path]:
    """Give a temporary path beside `path` and move it to `path` when the block ends without an exception.

    An existing file is replaced; nothing is left behind, and an existing file stays, when the block raises.

    Raises
    ------
    InputError
        Before the block runs, when `path` is a folder or its folder cannot be written. At its end, when that is so by
        then, or the disk is full.
    """
    path = Path(path)
    _check_no_folder(path)
    with _part(path, _new_file, 0o666) as part:
        yield part


@contextmanager
def _part(path: Path, make: Callable[[str, str, Path], str], mode: int) -> Iterator[Path]:
    """Give what `make` makes beside `path`, moved there at the end of the block and removed where it raises."""
    true = Path(os.path.realpath(path))  # a link stays one; not resolve(): it raises where links go round in a circle
    made = _make_parents(true, path)
    try:
        part = Path(make(".part", f".{true.name}.", true.parent))
    except OSError as error:
        _remove_empty(made)
        raise _cannot_write(path, error) from error
    try:
        yield part
        stop_if_asked()
        _move(part, true, mode, path)
    except BaseException as error:
        _remove(part)
        _remove_empty(made)
        if isinstance(error, OSError) and error.errno in FULL:
            raise _cannot_write(path, error) from error
        raise


def _new_file(suffix: str, prefix: str, folder: Path) -> str:
    handle, name = tempfile.mkstemp(suffix, prefix, folder)
    os.close(handle)
    return name


def _move(part: Path, true: Path, mode: int, path: Path) -> None:
    try:
        part.chmod(mode & ~_umask())  # a temporary one is private; the result should be as readable as any
        part.replace(true)
    except OSError as error:  # hours may have passed since the place was looked at
        raise _cannot_write(path, error) from error


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


def check_new(path: Path | str) -> None:
    """Raise `InputError` where a file, or a folder, of the name `path` is there already."""
    path = Path(path)
    try:
        _check_no_folder(path)
        if path.exists():
            raise InputError(f"{path}: output file exists already", "", "give a new name, or remove this one first")
    except OSError as error:
        raise _cannot_write(path, error) from error


def _check_no_folder(path: Path) -> None:
    if path.is_dir():
        raise InputError(f"{path}: cannot be written", "a folder", "give the name of a file")


def check_keeps(path: Path | str, read: Iterable[Path | str]) -> None:
    """Raise `InputError` where writing `path` would replace one of the files that are read, under whichever name."""
    for file in read:
        try:
            same = os.path.samefile(path, file)
        except (OSError, ValueError):  # one of them is not there; who reads or writes it says so
            continue
        if same:
            raise InputError(f"{path}: would replace what is read", str(file), "give the output a name of its own")


def _make_parents(true: Path, path: Path) -> list[Path]:
    """Make the missing parent folders of `true`, which was given as `path`; return those made, deepest first."""
    missing = [folder for folder in true.parents if not folder.exists()]
    try:
        true.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        _remove_empty(missing)
        raise _cannot_write(path, error) from error
    return missing


def _remove(part: Path) -> None:
    if part.is_dir():
        shutil.rmtree(part, ignore_errors=True)
    else:
        part.unlink(missing_ok=True)


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
