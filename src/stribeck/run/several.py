"""Several runs: names that tell them apart, and none of them twice."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Sequence
from dataclasses import replace
from itertools import count
from pathlib import Path

from stribeck.errors import InputError
from stribeck.run.file import load_run
from stribeck.run.values import Run


def load_runs(paths: Sequence[Path | str], n_joints: int, kinds: Sequence[str] = ()) -> list[Run]:
    """Read runs of one arm; files of the same name in several folders are named with as many folders as differ.

    Parameters
    ----------
    paths : sequence of path
        See :func:`load_run`.
    n_joints : int
        Number of joints that the arm has.
    kinds : sequence of str
        Of the joints; see :func:`load_run`.

    Returns
    -------
    list of Run
        ``run_0.csv``, ..; ``monday/run_0.csv``, .. where the files' own names do not tell them apart.
    """
    named = zip(paths, _names(paths), strict=True)
    return [replace(load_run(path, n_joints, kinds), name=name) for path, name in named]


def check_apart(runs: Sequence[Run]) -> None:
    """Raise `InputError` for two runs of one name, and for a recording that is there twice: it would judge itself."""
    names: set[str] = set()
    known: dict[bytes, str] = {}
    for run in runs:
        samples = _digest(run)
        if samples in known:
            raise InputError("a run is given twice", f"{known[samples]} and {run.name}", "give each recording once")
        if run.name in names:
            raise InputError("two runs have the same name", run.name, "give each run a name of its own")
        known[samples] = run.name
        names.add(run.name)


def _digest(run: Run) -> bytes:
    """Return what tells a run's samples; not its times, for a copy may be told as of another hour."""
    total = hashlib.sha256(run.q.tobytes())
    total.update(run.tau.tobytes())
    return total.digest()


def _names(paths: Sequence[Path | str]) -> list[str]:
    """Return a name for each path: its end, of all the same length, for names tell the order of recordings."""
    whole = [Path(os.path.abspath(path)).parts for path in paths]
    ends = next(ends for k in count(1) if len(set(ends := [parts[-k:] for parts in whole])) == len(set(whole)))
    return [Path(*parts).as_posix() for parts in ends]
