"""Which runs are kept back: never fitted, they judge what was."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from itertools import combinations

import numpy as np
from scipy.ndimage import uniform_filter1d

from stribeck.gap.records.sequence import order
from stribeck.identify.stretches import part
from stribeck.run import Run

HELD_SHARE = 0.3  # of a single run
EVERY = 3  # runs, of which one is held out
BEYOND = 0.25  # of what all runs reach: further than that beyond every other run, a run stands alone
MOVED = 0.25  # of the speed at which the run moves a joint that moves it second most: slower, it as good as rests
FIRST = 1e-6  # counts as standing alone by so little
SHOWN = 1e3  # counts as standing alone by so much, of parts: more than any motion does
FAINT = 0.05  # of what is asked on average: less is as good as nothing
DIGITS = 9  # of how far runs are from others, and from alike: what rounding leaves must not decide
AVERAGED = 0.05  # s: from sample to sample, a joint that rests moves by its encoder's noise
ALIKE = 0.3  # rms of the logarithms of what held runs ask, over that of fitted ones: they move alike up to here


def split(runs: Sequence[Run], notes: list[str], fitted: Collection[str] = ()) -> tuple[list[Run], list[Run]]:
    """Return (fit, held out): one whole run of three is kept back, or the last part of a single run.

    A run that goes where no other goes (a larger torque, speed or range) is fitted: what only one recording shows
    cannot be learnt from the others; so is, where it can be, the first, for it alone shows what had been before. Of the
    rest, those are kept back that together move like the fitted ones: what a law closes on tame motions alone says
    little of what it closes on the others. Before all of it, both move every joint that two runs move, if one more run
    must be kept back for it: what is wrong at a joint that rests is not seen.
    """
    if len(runs) == 1:
        run = runs[0]
        k = _cut(run)
        notes.append(f"{run.name}: the last {1.0 - k / len(run.t):.0%} is held out")
        return [part(run, 0, k)], [part(run, k, len(run.t))]
    alone, asked = _alone(runs), _asked(runs)
    first = order(runs)[0]
    alone[first] = max(alone[first], FIRST)
    shown = [i for i, run in enumerate(runs) if run.name in fitted]
    alone[shown] += SHOWN
    held: list[int] = []
    for i in range(1, len(runs), EVERY):
        near = sorted((k for k in range(len(runs)) if k not in held), key=lambda k: (abs(k - i), -k))
        held.append(next((k for k in near if not alone[k]), near[0]))
    held = _exchanged(held, asked, _moved(asked, runs[0].n), alone)
    notes.extend(f"{runs[i].name}: fitted, for it shows what no other fitted one does" for i in shown if i not in held)
    return [run for i, run in enumerate(runs) if i not in held], [runs[i] for i in held]


def _cut(run: Run) -> int:
    """Return the first sample of the part of a single run that is held out: its last part in time.

    Where a joint as good as rests in that, the last part of the way that all joints go together.
    """
    way = np.cumsum(np.abs(_speed(run)), axis=0)
    way /= way[-1] + np.finfo(float).tiny
    cut = round((1.0 - HELD_SHARE) * len(run.t))
    if np.all((1.0 - way[cut - 1] > MOVED * HELD_SHARE) | (way[-1] == 0.0)):
        return cut
    moved = int(np.searchsorted(way.sum(axis=1), (1.0 - HELD_SHARE) * way[-1].sum())) + 1
    return max(moved, round(HELD_SHARE * len(run.t)))


def _alone(runs: Sequence[Run]) -> np.ndarray:
    """Return how far each run (R,) goes beyond all others in torque, speed or range, summed over joints.

    As parts of what all runs reach, each without ``BEYOND``; 0 for a run that does not stand alone.
    """
    reach = []
    for run in runs:
        fast, hard = np.quantile(np.abs(_speed(run)), 0.99, axis=0), np.max(np.abs(run.tau), axis=0)
        reach.append(np.concatenate([fast, hard, run.q.max(axis=0), -run.q.min(axis=0)]))
    values = np.array(reach)
    n = runs[0].n
    span = np.concatenate(
        [values.max(axis=0)[: 2 * n], np.tile((values[:, 2 * n : 3 * n] + values[:, 3 * n :]).max(axis=0), 2)]
    )
    second = np.sort(values, axis=0)[-2]
    further = np.maximum(values - second - BEYOND * span, 0.0)
    span = np.maximum(span, further)  # a joint may rest in every run, each time elsewhere
    return np.asarray(np.round(np.sum(further / (span + np.finfo(float).tiny), axis=1), DIGITS))


def _asked(runs: Sequence[Run]) -> np.ndarray:
    """Return what each run asks of its joints (R, 4 n): speed, its square, those of torque and position about the mean.

    Sums over time; in a last column the time itself, s.
    """
    rest, pose = (np.mean([getattr(run, name).mean(axis=0) for run in runs], axis=0) for name in ("tau", "q"))
    rows = []
    for run in runs:
        step, speed = np.diff(run.t)[:, None], _speed(run)
        asked = (np.abs(speed), speed**2, (run.tau[:-1] - rest) ** 2, (run.q[:-1] - pose) ** 2)
        rows.append(np.append(np.concatenate([np.sum(each * step, axis=0) for each in asked]), step.sum()))
    return np.array(rows)


def _speed(run: Run) -> np.ndarray:
    width = max(1, round(AVERAGED / run.sample_time))
    return np.asarray(np.diff(uniform_filter1d(run.q, width, axis=0), axis=0) / np.diff(run.t)[:, None])


def _moved(asked: np.ndarray, n: int) -> np.ndarray:
    """Return which of its joints each run moves (R, n), as the run does that moves them second most.

    None, where only one run moves a joint: that is one for which nothing can be done.
    """
    speed = asked[:, :n] / asked[:, -1:]
    second = np.sort(speed, axis=0)[-2]
    return np.asarray((speed >= MOVED * second) & (second > FAINT * speed.mean(axis=0)))


def _exchanged(held: Sequence[int], asked: np.ndarray, moved: np.ndarray, alone: np.ndarray) -> list[int]:
    """Return runs that are held out: exchanged, one by one, for others while that helps, and one more where none does.

    One that should be fitted and moves joints as no other run does is exchanged for two.

    Most it helps that both held and fitted runs move every joint; for that alone one more is held out. Then that what
    stands ``alone`` is fitted; then, where held and fitted runs are not alike, that they come to ask more alike.
    """
    n = moved.shape[1]
    table = np.column_stack([asked, moved, alone])  # all of it adds up, over any set of runs
    total = table.sum(axis=0)
    mean = total[: -n - 2] / total[-n - 2] + np.finfo(float).tiny

    def loss(there: np.ndarray) -> np.ndarray:  # (..., 3) of sums over held runs (..., f): the first counts most
        both = np.stack([there, total - there])
        each = np.log(both[..., : -n - 2] / both[..., -n - 2 : -n - 1] / mean + FAINT)
        apart = np.round(np.sqrt(np.mean((each[0] - each[1]) ** 2, axis=-1)), DIGITS)
        still = np.sum((total[-n - 1 : -1] > 0) & np.any(both[..., -n - 1 : -1] == 0, axis=0), axis=-1)
        return np.stack([still, there[..., -1], np.where(apart > ALIKE, apart, 0.0), apart], axis=-1)

    best = list(held)
    while others := [k for k in range(len(table)) if k not in best]:
        here = table[best].sum(axis=0)
        now, after = loss(here), loss(here - table[best][:, None] + table[others])
        more = loss(here + table[others]) if len(others) > 1 else now[None]  # some run is fitted
        out, come = np.unravel_index(_least(after), after.shape[:2])
        joined = _least(more)
        if more[joined, 0] < now[0] and tuple(more[joined, :2]) < tuple(after[out, come, :2]):
            best = sorted([*best, others[joined]])
        elif tuple(after[out, come, :3]) < tuple(now[:3]):
            best = sorted([*best[:out], *best[out + 1 :], others[come]])
        elif now[1] >= SHOWN and (two := _for_two(best, others, table, now, loss)):
            best = two
        else:
            break
    return best


def _for_two(
    held: Sequence[int], others: Sequence[int], table: np.ndarray, now: np.ndarray, loss: Callable[..., np.ndarray]
) -> list[int]:
    """Return held runs with two others in place of one that should be fitted, where that is better; else an empty list.

    It may move joints in held runs that none of the others moves alone. Some run is fitted besides.
    """
    if len(others) < 3:
        return []
    pairs = np.array(list(combinations(others, 2)))
    for out in (k for k in held if table[k, -1] >= SHOWN):
        rest = [k for k in held if k != out]
        losses = loss(table[rest].sum(axis=0) + table[pairs].sum(axis=1))
        least = _least(losses)
        if tuple(losses[least, :2]) < tuple(now[:2]):
            return sorted([*rest, *pairs[least].tolist()])
    return []


def _least(losses: np.ndarray) -> int:
    """Return the index of the row that is least in the first of its numbers (..., f), or in the next where even."""
    return int(np.lexsort(losses.reshape(-1, losses.shape[-1]).T[::-1])[0])
