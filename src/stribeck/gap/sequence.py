"""The order in which recordings were made, and how far each joint had gone before each of them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from stribeck.identify.conditioning import Conditioned


def in_sequence(runs: Sequence[Conditioned]) -> tuple[Conditioned, ...]:
    """Return the runs, each told the distance that every joint had gone in those recorded before it.

    Times that do not overlap are of one clock and tell the order. Otherwise the names do, numbers in them counted.
    """
    spans = sorted((float(run.time[0]), float(run.time[-1])) for run in runs)
    one_clock = all(before[1] < after[0] for before, after in pairwise(spans))
    order = sorted(range(len(runs)), key=lambda i: (() if one_clock else _counted(runs[i].name), runs[i].time[0]))
    gone = np.zeros(runs[0].position.shape[1])
    before = [gone] * len(runs)
    for i in order:
        before[i] = gone
        gone = gone + np.sum(np.abs(runs[i].velocity), axis=0) * runs[i].sample_time
    return tuple(replace(run, before=distance) for run, distance in zip(runs, before, strict=True))


def _counted(name: str) -> tuple[tuple[int, str], ...]:
    """Return a sorting key by which run_2 comes before run_10."""
    parts = re.findall(r"\d+|\D+", name)
    return tuple((int(part), "") if part.isdecimal() else (-1, part) for part in parts)
