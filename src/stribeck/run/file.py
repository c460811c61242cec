"""Read and write a run as CSV or Parquet."""

from __future__ import annotations

import csv
import dataclasses
import io
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet
from numpy.typing import NDArray

from stribeck.errors import InputError
from stribeck.outputs import whole_file
from stribeck.run.checks import check_time, check_units
from stribeck.run.header import to_do
from stribeck.run.table import read_table
from stribeck.run.values import Floats, Run

_REQUIRED = {"q": "q{}", "tau": "tau{}"}
_OPTIONAL = {
    "dq": "dq{}",
    "q_ref": "q{}_ref",
    "dq_ref": "dq{}_ref",
    "tau_meas": "tau{}_meas",
    "temperature": "temperature{}",
}
_PARQUET = (".parquet", ".pq")


def load_run(path: Path | str, n_joints: int, kinds: Sequence[str] = ()) -> Run:
    """Read a run of an arm with `n_joints` joints.

    Parameters
    ----------
    path : path
        A file that ends in ``.csv``, ``.parquet`` or ``.pq``.
    n_joints : int
        Number of joints that the arm has.
    kinds : sequence of str
        Of the joints, ``revolute`` or ``prismatic``, for the units in what is said; none are given: all revolute.

    Returns
    -------
    Run
        Its `warnings` name unused columns and doubtful units, and count rows that are there twice.

    Raises
    ------
    InputError
        One line: the file, the row or column, what was found and what to do.
    """
    path = Path(path)
    _check_suffix(path)
    numbers, extra = read_table(path, _chooser(path, n_joints))
    again = _again(numbers, extra)
    if again.any():
        numbers = {name: values[~again] for name, values in numbers.items()}
        extra = None if extra is None else extra.filter(pa.array(~again))
    check_time(numbers["t"], path, np.flatnonzero(~again) + (1 if path.suffix.lower() in _PARQUET else 2))
    t = numbers.pop("t")
    groups: dict[str, Any] = {
        key: _stack(numbers, [pattern.format(k + 1) for k in range(n_joints)])
        for key, pattern in {**_REQUIRED, **_OPTIONAL}.items()
        if pattern.format(1) in numbers
    }
    run = Run(name=path.name, t=t, extra=extra, **groups)
    unused = () if extra is None else (f"columns not used: {', '.join(extra.column_names)}",)
    twice = (f"rows that repeat the one before in every column, left out: {again.sum()}",) if again.any() else ()
    return dataclasses.replace(
        run, warnings=(*unused, *twice, *check_units(run, path, kinds or ["revolute"] * n_joints))
    )


def _again(numbers: Mapping[str, Floats], extra: pa.Table | None) -> NDArray[np.bool_]:
    """Return which rows (N,) say the same as the one before, time included: a logger wrote them twice."""
    rows = np.flatnonzero(np.diff(numbers["t"]) == 0.0) + 1
    for values in numbers.values():
        rows = rows[values[rows] == values[rows - 1]]
    for column in () if extra is None else extra.columns:
        now, before = (column.take(pa.array(some)).to_pylist() for some in (rows, rows - 1))
        rows = rows[np.array([str(a) == str(b) for a, b in zip(now, before, strict=True)], dtype=bool)]
    again = np.zeros(len(numbers["t"]), dtype=bool)
    again[rows] = True
    return again


def save_run(run: Run, path: Path | str) -> None:
    """Write a run, whole or not at all; `load_run` gives the same numbers back.

    Parameters
    ----------
    run : Run
        Its `extra` columns are written too.
    path : path
        A file that ends in ``.csv``, ``.parquet`` or ``.pq``.
    """
    columns: dict[str, pa.Array | pa.ChunkedArray] = {"t": pa.array(run.t)}
    for key, pattern in {**_REQUIRED, **_OPTIONAL}.items():
        values = getattr(run, key)
        if values is not None:
            columns |= {pattern.format(k + 1): pa.array(values[:, k]) for k in range(run.n)}
    if run.extra is not None:
        columns |= dict(zip(run.extra.column_names, run.extra.columns, strict=True))
    save_columns(columns, path)


def save_columns(columns: Mapping[str, Any], path: Path | str) -> None:
    """Write a table whole or not at all; every number reads back exactly.

    Parameters
    ----------
    columns : mapping
        Column name -> (N,) array.
    path : path
        A file that ends in ``.csv``, ``.parquet`` or ``.pq``.
    """
    path = Path(path)
    _check_suffix(path)
    table = pa.table(dict(columns))
    with whole_file(path) as part:
        if path.suffix.lower() in _PARQUET:
            pa.parquet.write_table(table, part)
        else:
            _write_csv(table, part)


def _write_csv(table: pa.Table, path: Path) -> None:
    header = io.StringIO()  # Arrow would put every name in quotes, which simple readers take as part of the name
    csv.writer(header, lineterminator="\n").writerow(table.column_names)
    with path.open("wb") as stream:
        stream.write(header.getvalue().encode("utf-8"))
        pa.csv.write_csv(table, stream, pa.csv.WriteOptions(include_header=False))


def _chooser(path: Path, n: int) -> Callable[[list[str]], set[str]]:
    """Return the function that picks a run's columns from a header, complete groups only."""
    required = ["t", *(p.format(k + 1) for p in _REQUIRED.values() for k in range(n))]
    optional = [[p.format(k + 1) for k in range(n)] for p in _OPTIONAL.values()]

    def choose(names: list[str]) -> set[str]:
        shown = ", ".join(names)
        missing = [name for name in required if name not in names]
        if missing:
            what = f"{path}: column {missing[0]} is missing" if len(missing) == 1 else f"{path}: columns missing: "
            what += "" if len(missing) == 1 else ", ".join(missing)
            raise InputError(what, shown, to_do(missing, names, required, n))
        over = [name for name in names if (match := re.fullmatch(r"(?:q|tau)([1-9]\d*)", name)) and int(match[1]) > n]
        if over:
            what = f"{path}: has more joints than the arm, which has {n}"
            raise InputError(what, ", ".join(over), "give the arm file that belongs to this recording")
        return {*required, *(name for group in optional if set(group) <= set(names) for name in group)}

    return choose


def _stack(numbers: dict[str, Floats], names: list[str]) -> Floats:
    """Move columns into one (N, n) array, each freed as it is copied: long recordings are large."""
    stacked = np.empty((len(numbers[names[0]]), len(names)))
    for k, name in enumerate(names):
        stacked[:, k] = numbers.pop(name)
    return stacked


def _check_suffix(path: Path) -> None:
    if path.suffix.lower() not in (".csv", *_PARQUET):
        raise InputError(f"{path}: unknown kind of table", path.suffix or "no ending", "use .csv or .parquet")
