"""Positions that a counter begins anew after each turn, put together again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stribeck.run.values import Floats, Run

TURN = 2.0 * np.pi
NEAR = 0.5  # rad, that a step may be off whole turns: a joint moves less from sample to sample
MISSING = 1.5  # median steps: rows are missing in a longer one
SPAN = 4  # rows over which a speed is told, and as many more of which the middle one is taken
FORESEEN = np.pi  # rad, that a joint may go where rows are missing: beyond, speeds around tell no turn
WRONG = 2  # rows off by a turn that may be wrong readings
WITHIN = (1.0, 99.0)  # per cent of a joint's positions: wrong readings lie outside


def turned_on(q: Floats, t: Floats) -> tuple[Floats, NDArray[np.int_]]:
    """Return positions without leaps by whole turns, and how many leaps there were.

    Where rows are missing, a joint may have gone on besides, by the speeds before and after.

    Parameters
    ----------
    q : array (N, n)
        Recorded positions, rad.
    t : array (N,)
        Times, increasing, s.

    Returns
    -------
    q : array (N, n)
        In the turn of the first sample, and on from there; the same array where nothing leaps.
    leaps : array (n,) of int
        Of each joint.
    """
    step = np.diff(q, axis=0)
    turns = np.rint(step / TURN)
    unclear = np.abs(step - TURN * turns) > NEAR
    turns[unclear] = 0.0
    if unclear.any():
        turns += _while_missing(step - TURN * turns, np.diff(t), unclear)
    leaps = np.count_nonzero(turns, axis=0)
    if not leaps.any():
        return q, leaps
    joined = q.copy()
    joined[1:] -= TURN * np.cumsum(turns, axis=0)
    return joined, leaps


def in_one_turn(runs: Sequence[Run], notes: list[str]) -> list[Run]:
    """Return runs moved by whole turns to where the others are; the same ones where nothing is to be moved.

    A joint whose counter begins anew is recorded in one turn or the next, by where it happens to be at first. Of joints
    that never leap in any run, turns mean what they say.

    Parameters
    ----------
    runs : sequence of Run
        Of one arm, as recorded.
    notes : list of str
        Is told what was done.
    """
    told = [turned_on(run.q, run.t) for run in runs]
    turns = np.zeros((len(runs), runs[0].n))
    for j in np.flatnonzero(np.any([_begins_anew(run.q, q) for run, (q, _) in zip(runs, told, strict=True)], axis=0)):
        turns[:, j] = _turns_apart(np.array([np.percentile(q[:, j], WITHIN) for q, _ in told]))
    out = []
    for run, own in zip(runs, turns, strict=True):
        if own.any():
            moved = ", ".join(f"q{k + 1} ({count:+.0f})" for k, count in enumerate(own) if count)
            notes.append(f"{run.name}: moved by whole turns to where the other recordings are: {moved}")
            q_ref = None if run.q_ref is None else run.q_ref + TURN * own
            run = replace(run, q=run.q + TURN * own, q_ref=q_ref)
        out.append(run)
    return out


def _begins_anew(recorded: Floats, joined: Floats) -> NDArray[np.bool_]:
    """Return of each joint whether its counter began anew, for longer than a wrong reading or two."""
    turned = np.rint((recorded - joined) / TURN)
    return np.asarray(np.count_nonzero(turned != np.median(turned, axis=0), axis=0) > WRONG)


def _turns_apart(ranges: Floats) -> Floats:
    """Return the turns (K,) by which ranges (K, 2) of a joint, rad, are to be moved for them to overlap most.

    As many as can stay where they are; so do those that would come no nearer than NEAR to the others.
    """
    turns, beside = np.zeros(len(ranges)), np.full(len(ranges), True)
    widest, *others = np.argsort(ranges[:, 0] - ranges[:, 1], kind="stable")
    low, high = ranges[widest]
    for i in others:
        first, last = ranges[i]
        nearest = TURN * np.rint((low + high - first - last) / (2.0 * TURN))
        here, there = (min(high, last + moved) - max(low, first + moved) for moved in (0.0, nearest))
        if there > max(here, -NEAR):
            turns[i] = nearest / TURN
        beside[i] = max(here, there) > -NEAR
        low, high = min(low, first + TURN * turns[i]), max(high, last + TURN * turns[i])
    counts, often = np.unique(turns[beside], return_counts=True)
    return np.where(beside, turns - counts[often.argmax()], 0.0)


def _while_missing(step: Floats, time: Floats, unclear: NDArray[np.bool_]) -> Floats:
    """Return the turns (N, n) in steps that are unclear, rad, as far as rows are missing there."""
    turns, missing = np.zeros(step.shape), time > MISSING * np.median(time)
    if (unclear & missing[:, None]).any() and np.count_nonzero(~missing) > SPAN:
        gone = _gone(step, time, missing)
        more = np.rint((step[missing] - gone) / TURN)
        told = (np.abs(step[missing] - gone - TURN * more) <= NEAR) & (np.abs(gone) <= FORESEEN)
        turns[missing] = np.where(unclear[missing] & told, more, 0.0)
    return turns


def _gone(step: Floats, time: Floats, missing: NDArray[np.bool_]) -> Floats:
    """Return how far joints go where rows are missing, (K, n), rad, by the mean of their speeds before and after.

    Parameters
    ----------
    step : array (N, n)
        From sample to sample, rad.
    time, missing : array (N,)
        How long each takes, s, and whether rows are missing there.
    """
    way = np.cumsum(np.insert(step[~missing], 0, 0.0, axis=0), axis=0)
    clock = np.cumsum(np.insert(time[~missing], 0, 0.0))
    speed = (way[SPAN:] - way[:-SPAN]) / (clock[SPAN:] - clock[:-SPAN])[:, None]
    at = np.cumsum(~missing)[missing]  # the row before, of those that are left
    rows = np.arange(SPAN + 1)
    around = (at[:, None] + side + rows for side in (-2 * SPAN, 0))
    before, after = (np.median(speed[np.clip(near, 0, len(speed) - 1)], axis=1) for near in around)
    return np.asarray(0.5 * (before + after) * time[missing][:, None])
