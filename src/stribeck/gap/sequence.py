"""The order in which recordings were made, and what each joint had been through before each of them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from stribeck.identify.conditioning import Conditioned, Past


def in_sequence(runs: Sequence[Conditioned]) -> tuple[Conditioned, ...]:
    """Return the runs, or parts of runs, each told what was recorded before it.

    Times that do not overlap are of one clock and tell the order. Otherwise the names do, numbers in them counted.
    """
    spans = sorted((float(run.time[0]), float(run.time[-1])) for run in runs)
    one_clock = all(before[1] < after[0] for before, after in pairwise(spans))
    order = sorted(range(len(runs)), key=lambda i: (() if one_clock else _counted(runs[i].name), runs[i].time[0]))
    past = [Past()] * len(runs)
    now, last = Past(), None
    for i in order:
        run = runs[i]
        if last and (run.name != last.name or run.time[0] < last.time[-1]):
            now = replace(now, recordings=now.recordings + 1)
        past[i], last = now, run
        moved = np.sum(np.abs(run.velocity), axis=0) * run.sample_time
        now = Past(now.recordings, now.recorded + len(run.time) * run.sample_time, now.travelled + moved)
    return tuple(replace(run, past=before) for run, before in zip(runs, past, strict=True))


def _counted(name: str) -> tuple[tuple[int, str], ...]:
    """Return a sorting key by which run_2 comes before run_10."""
    parts = re.findall(r"\d+|\D+", name)
    return tuple((int(part), "") if part.isdecimal() else (-1, part) for part in parts)
