"""A recording whose commands were logged later, or earlier, than those of the others: none of the arm's doing.

A log may begin to write commands a sample before positions, or after, each time that it is started. What that leaves is
the rate of the command times the time, at all joints that move: at rest friction takes up any torque.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stribeck.gap.fitted.model import Model
from stribeck.gap.records.each_recording import NOTHING, recording_of_rows, slope_of_each
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.records.spread import noise_power, spread
from stribeck.identify.blocks import block_of_rows

LEAST = 3  # recordings, of which one may be late: of two, either may
MOSTLY = 0.5  # of a recording's squares, that its lateness must explain
SURE = 5.0  # standard errors, that it must be away from the next recording's
APART = 0.5  # of the way to the middle of the others, at least, that lies before the next of them
FAINT = 0.1  # of a sample: less is no slip of a log


def told_late_alone(prepared: Prepared, models: Sequence[Model], floor: np.ndarray) -> list[str]:
    """Return a warning for the recording that alone is late or early, by the first of some models that shows one.

    Parameters
    ----------
    prepared : Prepared
    models : sequence of Model
        Fitted to its recordings.
    floor : array (n,)
        Noise floor, N m rms.
    """
    runs = (*prepared.fit, *prepared.held)
    names = list(dict.fromkeys(run.name for run in runs))
    steps = {run.name: run.run.sample_time for run in runs}
    for model in models:
        late, error, share = _lateness(prepared, model, floor, names)
        for k, name in enumerate(names):
            away = [_away(k, *each, FAINT * steps[name]) for each in zip(late.T, error.T, share.T, strict=True)]
            told = [each for each in away if each is not None]
            if told and np.all(told):
                size, when = np.mean(np.abs(told)), "later" if np.mean(told) > 0.0 else "earlier"
                return [
                    f"{name}: commands come about {1e3 * size:.2g} ms {when} against positions than in the other "
                    f"recordings, where a sample takes {1e3 * steps[name]:.3g} ms: shift them, or leave it out"
                ]
    return []


def _away(k: int, late: np.ndarray, error: np.ndarray, share: np.ndarray, least: float) -> float | None:
    """Return how far the k-th recording's commands are from the others' at one joint, s; 0 where it is not alone.

    None where fewer than two of the others tell how late they are.
    """
    known = np.flatnonzero(np.isfinite(error) & (SURE * error < max(abs(late[k]), least)))
    others = late[known[known != k]]
    if k not in known or len(others) < LEAST - 1:
        return None
    away = float(late[k] - np.median(others))
    next_to_it = np.min(np.abs(others - late[k]))
    return away if share[k] > MOSTLY and next_to_it > max(SURE * error[k], APART * abs(away), least) else 0.0


def _lateness(
    prepared: Prepared, model: Model, floor: np.ndarray, names: Sequence[str]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return how late each recording's commands are at each joint, s, its block-robust standard error, and the share.

    That is of the squared residual, which the lateness explains; arrays (R, n). Infinite errors: nothing is known.
    """
    runs, whole = (*prepared.fit, *prepared.held), model.whole
    sd = spread(whole, noise_power(prepared.noise, floor, len(whole), model.rows))
    moves = np.concatenate([run.stuck[run.analysis_index] < 0.5 for run in runs]) / sd
    rate = np.concatenate([run.filtered(np.gradient(run.command, run.sample_time, axis=0)) for run in runs]) * moves
    left, block = whole * moves, block_of_rows(runs)
    of_row = recording_of_rows(runs, names)
    late, error, rest = slope_of_each(left, rate, of_row, block)
    squares = [[np.sum(each[of_row == k] ** 2, axis=0) for k in range(len(names))] for each in (rest, left)]
    share = 1.0 - np.asarray(squares[0]) / np.maximum(squares[1], NOTHING)
    return late, np.where(error > 0.0, error, np.inf), share
