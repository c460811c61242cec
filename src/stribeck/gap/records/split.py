"""Which runs are kept back: never fitted, they judge what was."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stribeck.identify.stretches import part
from stribeck.run import Run

HELD_SHARE = 0.3  # of a single run
EVERY = 3  # runs, of which one is held out
BEYOND = 0.25  # of what all runs reach: further than that beyond every other run, a run stands alone
FAINT = 0.05  # of what is asked on average: less is as good as nothing
DIGITS = 9  # of how far runs are from alike: what rounding leaves must not decide
ALIKE = 0.3  # rms of the logarithms of what held runs ask, over that of fitted ones: they move alike up to here


def split(runs: Sequence[Run], notes: list[str]) -> tuple[list[Run], list[Run]]:
    """Return (fit, held out): one whole run of three is kept back, or the last part of a single run.

    A run that goes where no other goes (a larger torque, speed or range) is fitted: what only one recording shows
    cannot be learnt from the others. Of the rest, those are kept back that together move like the fitted ones: what a
    law closes on tame motions alone says little of what it closes on the others.
    """
    if len(runs) == 1:
        run = runs[0]
        k = round((1.0 - HELD_SHARE) * len(run.t))
        notes.append(f"{run.name}: the last {HELD_SHARE:.0%} is held out")
        return [part(run, 0, k)], [part(run, k, len(run.t))]
    alone = _alone(runs)
    held: list[int] = []
    for i in range(1, len(runs), EVERY):
        near = sorted((k for k in range(len(runs)) if k not in held), key=lambda k: (abs(k - i), -k))
        held.append(next((k for k in near if not alone[k]), near[0]))
    held = _most_alike(held, _asked(runs), alone)
    return [run for i, run in enumerate(runs) if i not in held], [runs[i] for i in held]


def _alone(runs: Sequence[Run]) -> np.ndarray:
    """Return which runs (R,) go beyond all others in some joint's torque, speed or range, by a part of all runs'."""
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
    return np.asarray(np.any(values > second + BEYOND * span, axis=1))


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
    return np.asarray(np.diff(run.q, axis=0) / np.diff(run.t)[:, None])


def _most_alike(held: Sequence[int], asked: np.ndarray, alone: np.ndarray) -> list[int]:
    """Return runs that are held out: exchanged, one by one, for others that do not stand ``alone`` while that helps.

    It does where held and fitted runs, that were not alike, come to ask more alike.
    """
    total = asked.sum(axis=0)
    mean = total[:-1] / total[-1] + np.finfo(float).tiny

    def apart(there: np.ndarray) -> np.ndarray:  # from sums over the held runs (..., f + 1)
        each = (part[..., :-1] / part[..., -1:] / mean + FAINT for part in (there, total - there))
        return np.asarray(np.round(np.sqrt(np.mean(np.log(next(each) / next(each)) ** 2, axis=-1)), DIGITS))

    best, now = list(held), asked[held].sum(axis=0)
    while apart(now) > ALIKE and (others := [k for k in range(len(asked)) if k not in best and not alone[k]]):
        exchanged = now - asked[best][:, None] + asked[others]
        after = apart(exchanged)
        out, come = np.unravel_index(np.argmin(after), after.shape)
        if after[out, come] >= apart(now):
            break
        best, now = sorted([*best[:out], *best[out + 1 :], others[come]]), exchanged[out, come]
    return best
