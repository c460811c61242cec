"""The order in which recordings were made, and what each joint had been through before each of them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import casadi as ca
import numpy as np

from stribeck.identify.conditioning import Conditioned, Past
from stribeck.model.layout import Placed
from stribeck.model.path import SignalPath
from stribeck.model.values import Signals
from stribeck.run import Run

STRIDE = 0.02  # s between positions by which a distance is told


def in_sequence(runs: Sequence[Conditioned], recordings: Sequence[Run]) -> tuple[Conditioned, ...]:
    """Return runs, each told what was recorded before it.

    Parameters
    ----------
    runs : sequence of Conditioned
        Whole recordings, or parts of them that share their samples.
    recordings : sequence of Run
        All of them, whole.
    """
    past: dict[int, Past] = {}
    now = Past(travelled=np.zeros(recordings[0].n))
    for i in order(recordings):
        past[i], run = now, recordings[i]
        now = Past(
            now.recordings + 1, now.recorded + run.duration, now.travelled + distance_gone(run.q, run.sample_time)
        )
    return tuple(_placed(run, recordings, past) for run in runs)


def order(recordings: Sequence[Run]) -> list[int]:
    """Return the recordings' indices in the order in which they were made.

    Times that do not overlap are of one clock and tell it. Otherwise the names do, numbers in them counted, and then
    the order in which they are given.
    """
    spans = sorted((float(run.t[0]), float(run.t[-1])) for run in recordings)
    one_clock = all(before[1] < after[0] for before, after in pairwise(spans))
    keys = [(float(run.t[0]) if one_clock else 0.0, _counted(run.name)) for run in recordings]
    return sorted(range(len(recordings)), key=lambda i: (*keys[i], i))


def after(runs: Sequence[Conditioned]) -> Past:
    """Return the past of whatever is recorded after runs that have been told theirs."""
    last = max(runs, key=lambda run: (run.past.recordings, run.past.lead))
    past = last.past
    gone = past.travelled + past.led + distance_gone(last.position, last.sample_time)
    return Past(past.recordings + 1, past.recorded + past.lead + float(np.ptp(last.time)), gone)


def on_average(path: SignalPath, p: np.ndarray, runs: Sequence[Conditioned]) -> tuple[Placed, ...]:
    """Return a path's effects as they are, on average over the runs, where one starts: for an arm without a past."""
    still = ca.SX.zeros(path.x.numel())
    averaged = []
    for k, place in enumerate(path.placed):
        starts = [path.rubbed(k, _start(run.past, place.joint), still) for run in runs]
        friction = ca.Function("friction", [path.p], [ca.vertcat(*[s.friction for s in starts])])(p)
        told = [s.at(friction=float(value)) for s, value in zip(starts, ca.vertsplit(friction), strict=True)]
        averaged.append(replace(place, values=place.effect.on_average(place.values, told)))
    return tuple(averaged)


def _start(past: Past, joint: int) -> Signals:
    here = {"recordings": float(past.recordings), "recorded": past.recorded, "lead": past.lead}
    gone = {"travelled": float(np.asarray(past.travelled)[joint]), "led": float(np.asarray(past.led)[joint])}
    return Signals(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, **here, **gone)


def _placed(part: Conditioned, recordings: Sequence[Run], past: Mapping[int, Past]) -> Conditioned:
    i = next(i for i, run in enumerate(recordings) if run is part.run or np.shares_memory(run.q, part.run.q))
    recording = recordings[i]
    lead = float(part.run.t[0] - recording.t[0])
    led = distance_gone(recording.q[recording.t < part.run.t[0]], recording.sample_time)
    return replace(part, past=replace(past[i], lead=lead, led=led, whole=recording.duration))


def distance_gone(positions: np.ndarray, step: float) -> np.ndarray:
    """Return the distance (n,) that joints go along positions (N, n), hardly counting what noise goes to and fro."""
    seen = positions[:: max(1, round(STRIDE / step))]
    return np.asarray(np.sum(np.abs(np.diff(seen, axis=0)), axis=0))


def _counted(name: str) -> tuple[tuple[int, str], ...]:
    """Return a sorting key by which run_2 comes before run_10."""
    parts = re.findall(r"\d+|\D+", name)
    return tuple((int(part), "") if part.isdecimal() else (-1, part) for part in parts)
