"""Verdict and amplitude over a grid of loop settings, in chunks, on all cores or on a cluster."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from time import monotonic
from typing import Literal

import numpy as np
from joblib import Parallel, delayed
from numpy.typing import NDArray

from stribeck.arm import Arm
from stribeck.errors import InputError
from stribeck.loop.cycle import VERDICTS
from stribeck.loop.exact.engine import RoundsEngine
from stribeck.loop.exact.rounds import Rounds
from stribeck.loop.exact.settle import settle
from stribeck.loop.exact.shooting import shoot
from stribeck.loop.maps.cells import fits, kernel, run_cells, template_of
from stribeck.loop.maps.grid import Axes, check_axes, loop_of_cell
from stribeck.simulate import Loop

Floats = NDArray[np.float64]
Told = Callable[[float], None]
Labels = tuple[NDArray[np.int8], Floats]
_CHUNK = 512  # cells; what a chunk holds beside the map itself is a few hundred bytes a cell
_MOST_CELLS = 50_000_000
EVERY = 5.0  # s between two words of how far a map is
_AT_ONCE = 64  # chunks that a cluster holds


@dataclass(frozen=True)
class Map:
    """Labels of the cells of a grid.

    Attributes
    ----------
    axes : Axes
        Their values make the shape of the arrays.
    codes : array of int8
        Index into `VERDICTS`.
    amplitude, period, stick_fraction : array of float32
        rad, s, 1; not a number where there is no cycle. Where a sampled joint's velocity dies out before it turns, the
        least step that counts (1e-12 rad) sets the period.
    method : str
        ``cells`` (the map's own kernel) or ``events`` (shooting, cell by cell: slow).
    why : str
        Why it had to be ``events``.
    """

    axes: Axes
    codes: NDArray[np.int8]
    amplitude: NDArray[np.float32]
    period: NDArray[np.float32]
    stick_fraction: NDArray[np.float32]
    method: str
    why: str = ""

    @property
    def verdicts(self) -> NDArray[np.str_]:
        """The labels in words."""
        return np.array(VERDICTS)[self.codes]


def label_map(
    arm: Arm, loop: Loop, joint: str, axes: Mapping[str, Sequence[float] | Floats], *, jobs: int = -1,
    backend: Literal["joblib", "dask"] = "joblib", method: Literal["auto", "events"] = "auto",
    told: Told = lambda share: None,
) -> Map:  # fmt: skip
    """Return verdict, amplitude and period of a joint over a grid of loop settings.

    Parameters
    ----------
    arm : Arm
        With the effects of its file.
    loop : Loop
        Checked; what the grid does not vary is taken from it.
    joint : str
    axes : mapping of str to sequence of float
        Names as in `Axes`, and values; they make the grid.
    jobs : int
        Threads, as in joblib; -1 is all cores.
    backend : str
        ``dask`` spreads the chunks over the dask client in force, or over local threads where there is none.
    method : str
        ``events`` forces the event-driven reference, cell by cell.
    told : callable
        Is given the share of the cells that are done, every few seconds.

    Raises
    ------
    InputError
        When the grid is empty or out of range, the joint is not controlled, or dask is not installed.
    """
    if joint not in [entry.joint for entry in loop.joints]:
        raise InputError("the loop does not control this joint", repr(joint), "name one that it controls")
    grid = check_axes(axes, loop)
    if grid.size > _MOST_CELLS:
        raise InputError("the map has too many cells", f"{grid.size}", f"give at most {_MOST_CELLS}")
    rounds = Rounds(arm, loop)
    why = fits(rounds, joint) if method == "auto" else "it was asked for"
    if why:
        work: Callable[[int, int], Labels] = partial(_shoot_cells, rounds.engine, loop, joint, grid)
        _ = rounds.engine.rounds_library  # built once, before the threads want it
    else:
        kernel()
        work = partial(run_cells, template_of(rounds, joint), grid)
    step = _CHUNK if not why else 1
    edges = [(first, min(first + step, grid.size)) for first in range(0, grid.size, step)]
    done = _with_dask(work, edges) if backend == "dask" else _with_joblib(work, edges, jobs)
    return _collect(grid, edges, _counted(done, len(edges), told), why)


def _collect(grid: Axes, edges: list[tuple[int, int]], done: Iterator[Labels], why: str) -> Map:
    codes, sizes = np.zeros(grid.size, np.int8), np.full((3, grid.size), np.nan, np.float32)
    for (first, last), (code, size) in zip(edges, done, strict=True):
        codes[first:last], sizes[:, first:last] = code, size.T
    amplitude, period, stuck = (row.reshape(grid.shape) for row in sizes)
    return Map(grid, codes.reshape(grid.shape), amplitude, period, stuck, "events" if why else "cells", why)


def _counted(done: Iterator[Labels], count: int, told: Told) -> Iterator[Labels]:
    """Pass chunks on, and tell every few seconds how many of them there have been."""
    last = monotonic()
    for k, labels in enumerate(done, 1):
        yield labels
        if k < count and monotonic() - last >= EVERY:
            told(k / count)
            last = monotonic()


def _with_joblib(work: Callable[[int, int], Labels], edges: list[tuple[int, int]], jobs: int) -> Iterator[Labels]:
    count = os.cpu_count() or 1 if jobs == -1 else jobs
    parallel = Parallel(n_jobs=count, prefer="threads", return_as="generator", pre_dispatch="4*n_jobs")
    yield from parallel(delayed(work)(first, last) for first, last in edges)


def _with_dask(work: Callable[[int, int], Labels], edges: list[tuple[int, int]]) -> Iterator[Labels]:
    try:
        dask = import_module("dask")
    except ImportError as error:
        raise InputError("dask is not installed", "", "install stribeck[cluster], or use joblib") from error
    for begin in range(0, len(edges), _AT_ONCE):  # so that no more than these are held at a time
        part = edges[begin : begin + _AT_ONCE]
        yield from dask.compute(*(dask.delayed(work)(first, last) for first, last in part))


def _shoot_cells(engine: RoundsEngine, loop: Loop, joint: str, grid: Axes, first: int, last: int) -> Labels:
    settings = grid.settings(first, last)
    entry = next(e for e in loop.joints if e.joint == joint)
    inertia = float(Rounds(engine, loop).inertia[engine.arm.names.index(joint)])
    codes, sizes = np.zeros(last - first, np.int8), np.full((last - first, 3), np.nan)
    for i in range(last - first):
        cell = {name: float(values[i]) for name, values in settings.items()}
        one = loop_of_cell(loop, entry, inertia, cell)
        found = shoot(engine, one)[joint]
        if found.verdict == "undetermined":  # as under noise and dither always
            found = settle(engine, one)[joint]
        codes[i] = VERDICTS.index(found.verdict)
        if found.cycles:
            sizes[i] = [found.amplitude, found.period, found.stick_fraction]
    return codes, sizes
