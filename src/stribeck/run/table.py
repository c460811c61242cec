"""Columns of numbers from a CSV or Parquet file, read block by block so that memory stays bounded."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Collection, Iterable, Iterator
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.csv
import pyarrow.parquet

from stribeck.errors import InputError
from stribeck.run.header import is_number
from stribeck.run.values import Floats
from stribeck.textfile import check_regular, explain_unreadable

_LONGEST_HEADER = 1 << 20
_BLOCK = 1 << 22
_ROWS = 1 << 17

Chooser = Callable[[list[str]], Collection[str]]


def read_table(path: Path, choose: Chooser) -> tuple[dict[str, Floats], pa.Table | None]:
    """Read the columns that `choose` picks from the header as finite float64, and the others as they are.

    Parameters
    ----------
    path : path
        A ``.csv`` or ``.parquet`` file.
    choose : callable
        Takes the column names of the file and returns those to read as numbers; raises `InputError` when it
        misses one.

    Returns
    -------
    numbers : dict
        Column name -> (N,) array.
    extra : pyarrow.Table or None
        The other columns.

    Raises
    ------
    InputError
        One line with the row and the value when a chosen column holds anything but a finite number. In a CSV file
        the header is row 1, as in a spreadsheet; in a Parquet file the first sample is row 1.
    """
    _check_regular(path)
    try:
        if path.suffix.lower() in (".parquet", ".pq"):
            file = pa.parquet.ParquetFile(path)
            names = [name.strip() for name in file.schema_arrow.names]
            return _collect(path, names, file.iter_batches(batch_size=_ROWS), choose, first_row=1)
        names = _header(path)
        return _collect(path, names, _csv_batches(path, names), choose, first_row=2)
    except pa.ArrowException as error:
        raise _explain_arrow(path, error) from error
    except OSError as error:  # Arrow reports damaged Parquet pages as an OSError without a number
        raise explain_unreadable(path, error) from error


def _collect(
    path: Path, names: list[str], batches: Iterable[pa.RecordBatch], choose: Chooser, first_row: int
) -> tuple[dict[str, Floats], pa.Table | None]:
    _check_apart(path, names)
    chosen = choose(names)
    chunks: dict[str, list[Floats]] = {name: [] for name in names if name in chosen}
    others = [name for name in names if name not in chosen]
    extra: list[pa.RecordBatch] = []
    row = first_row
    for raw in batches:
        batch = raw.rename_columns(names)
        for name, parts in chunks.items():
            parts.append(_numbers(batch.column(name), f"{path}: column {name}", row))
        if others:
            extra.append(batch.select(others))
        row += batch.num_rows
    numbers = {name: np.concatenate([np.empty(0), *chunks.pop(name)]) for name in list(chunks)}
    return numbers, pa.Table.from_batches(extra) if extra else None


def _check_apart(path: Path, names: list[str]) -> None:
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise InputError(f"{path}: two columns have the same name", repr(name), "rename or remove one")
        seen.add(name)


def _numbers(column: pa.Array, where: str, row: int) -> Floats:
    """Convert one block; say the row and the value of the first entry that is not a finite number."""
    try:
        values: Floats = _cast(column)
    except pa.ArrowException:
        index = next(i for i in range(len(column)) if not _is_number(column.slice(i, 1)))
        found = column[index].as_py()
        shown = "an empty cell" if found in ("", None) else repr(found)
        raise InputError(f"{where}, row {row + index}: not a number", shown, "correct or remove that row") from None
    bad = ~np.isfinite(values)
    if bad.any():
        index = int(bad.argmax())
        found = column[index].as_py()
        shown = "an empty cell" if found is None else str(found)
        do = "fill it in or remove the column or the rows"
        raise InputError(f"{where}, row {row + index}: not a finite number", shown, do)
    return values


def _cast(column: pa.Array) -> Floats:
    if pa.types.is_dictionary(column.type):
        column = column.dictionary_decode()
    if pa.types.is_boolean(column.type):
        raise pa.ArrowInvalid("truth values are not numbers")
    if pa.types.is_string(column.type) or pa.types.is_large_string(column.type):
        column = pc.utf8_trim_whitespace(column)
    values: Floats = pc.cast(column, pa.float64()).to_numpy(zero_copy_only=False)
    return values


def _is_number(entry: pa.Array) -> bool:
    try:
        _cast(entry)
    except pa.ArrowException:
        return False
    return True


def _csv_batches(path: Path, names: list[str]) -> Iterator[pa.RecordBatch]:
    """Read every column as text: our own conversion can then name the row, which Arrow's cannot reliably."""
    reading = pa.csv.ReadOptions(use_threads=False, block_size=_BLOCK, column_names=names, skip_rows=1)
    texts = pa.csv.ConvertOptions(column_types=dict.fromkeys(names, pa.string()), strings_can_be_null=False)
    with pa.csv.open_csv(path, read_options=reading, convert_options=texts) as reader:
        yield from reader


def _explain_arrow(path: Path, error: Exception) -> InputError:
    """Word the one fault that people make by hand, a row of the wrong width; pass Arrow's words on otherwise."""
    ragged = re.search(r"Row #(\d+): Expected (\d+) columns, got (\d+)", str(error))
    if ragged:
        row, expected, found = ragged.groups()
        return InputError(f"{path}: row {row} must have {expected} values, as the header", found, "correct that row")
    return InputError(f"{path}: cannot be read as {_format(path)}", str(error), "repair it or export it again")


def _header(path: Path) -> list[str]:
    with path.open("rb") as stream:
        head = stream.read(_LONGEST_HEADER + 1)
    if not head.strip():
        raise InputError(f"{path}: the file is empty", "", "give a recording with a header row and one row a sample")
    if head.startswith(b"PAR1"):
        raise InputError(f"{path}: is not a CSV file", "Parquet", "name it with the ending .parquet")
    if b"\0" in head:
        raise InputError(f"{path}: is not a CSV file", "binary data", "export the recording as CSV in UTF-8")
    line = re.split(rb"[\r\n]", head, maxsplit=1)[0]
    if len(line) > _LONGEST_HEADER:
        raise InputError(f"{path}: row 1 is longer than 1 MiB", "", "give a CSV file with one row a sample")
    try:
        names = [name.strip() for name in next(csv.reader([line.decode("utf-8-sig")]), [])]
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: the header is not text in UTF-8", str(error), "export it in UTF-8") from error
    except csv.Error as error:
        raise InputError(
            f"{path}: row 1 is no row of names", str(error), "give a CSV file with one row a sample"
        ) from error
    if len(names) < 2:
        raise InputError(
            f"{path}: row 1 names no columns", repr(",".join(names)), "name them in row 1, with commas between"
        )
    if all(is_number(name) for name in names):
        do = "write the names of the columns above it, as t,q1,tau1 for one joint"
        raise InputError(f"{path}: row 1 is no header, but numbers", ",".join(names), do)
    return names


def _check_regular(path: Path) -> None:
    try:
        check_regular(path, "give the path of a CSV or Parquet file")
        with path.open("rb"):
            pass
    except OSError as error:
        raise explain_unreadable(path, error) from error
    except ValueError as error:  # a null character, which no system's names have
        raise InputError("a file cannot be read", repr(str(path)), "give the path of a readable file") from error


def _format(path: Path) -> str:
    return "Parquet" if path.suffix.lower() in (".parquet", ".pq") else "CSV"
