"""One joint's turns: its rounds, their average, after how many they repeat, and whether they die out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
TINY = 1e-7  # rad; a smaller motion is no cycle
CREEP = 1e-5  # rad; a motion of which this little is left, and ever less, comes to rest
_MOST_FOLD = 6


def weighted(values: Floats) -> float:
    """Return the mean of a quasi-periodic sequence, weighted by a bump: its error falls faster than any power.

    Das, Saiki, Sander and Yorke (2017), Quantitative quasiperiodicity, Nonlinearity 30.
    """
    if len(values) < 8:
        return float(np.mean(values))
    x = np.arange(1, len(values) + 1) / (len(values) + 1.0)
    weight = np.exp(-1.0 / (x * (1.0 - x)))
    return float(np.sum(weight * values) / np.sum(weight))


def whole_rounds(turns: np.ndarray) -> np.ndarray:
    """Return one joint's turns with its small ones merged into the large rounds that they interrupt.

    Noise and sampling make a joint turn a little on its way; a round is a swing over a quarter of the whole range.
    """
    if len(turns) < 2:
        return turns
    least = 0.25 * float(turns["high"][1:].max() - turns["low"][1:].min())
    kept = [turns[0].copy()]
    pending: np.ndarray | None = None
    for row in turns[1:]:
        pending = row.copy() if pending is None else _joined(pending, row)
        peak = kept[-1]
        if peak["deviation"] - pending["low"] < least:  # hardly left the last turn
            if row["deviation"] > peak["deviation"]:  # which goes on to here
                kept[-1] = _joined(peak, pending) if len(kept) > 1 else row.copy()
                pending = None
        elif row["deviation"] - pending["low"] >= least:
            kept.append(pending)
            pending = None
    return np.array(kept[1:], dtype=turns.dtype)


def _joined(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return the turn at the end of the second of two successive rounds, with both rounds behind it."""
    out = second.copy()
    out["low"], out["high"] = min(first["low"], second["low"]), max(first["high"], second["high"])
    out["speed"], out["stuck"] = max(first["speed"], second["speed"]), first["stuck"] + second["stuck"]
    return out


def fold_of(deviation: Floats, alike: float) -> int:
    """Return after how many turns, of which these are the deviations, the motion nearly repeats.

    Turns within ``alike`` (rad) of each other are the same: one round after the other.
    """
    if len(deviation) < 2 * _MOST_FOLD:
        return 1
    tail = deviation[-2 * _MOST_FOLD :]
    misses = [float(np.max(np.abs(tail[m:] - tail[:-m]))) for m in range(1, _MOST_FOLD + 1)]
    best = int(np.argmin(misses))
    near = next(m for m, miss in enumerate(misses, 1) if miss <= 3.0 * misses[best])
    return 1 if misses[0] <= alike else near


def dies_out(mine: np.ndarray) -> bool:
    """Tell whether one joint's rounds have become too small for a cycle, or are about to: creep to rest in steps."""
    spread = 0.5 * (mine["high"] - mine["low"])
    if len(spread) >= 4 and spread[len(spread) // 2 :].max() >= CREEP:
        return False  # one turn among large ones may be tiny: where a sampled joint stops, it turns once more
    if len(spread) < 2 or not spread[-1] < spread[0]:
        return bool(len(spread) and spread.max() < TINY)
    creeps = len(spread) >= 8 and spread[-1] < 0.7 * spread[-8] and bool((np.diff(spread[-8:]) < 0.0).all())
    return bool(spread[-1] < TINY or (spread[-1] < CREEP and creeps))


def falls(mine: np.ndarray) -> bool:
    """Tell whether one joint's last rounds were small and ever smaller, each less than half the one before."""
    spread = 0.5 * (mine["high"] - mine["low"])
    return len(spread) >= 4 and bool(spread[-1] < CREEP and (spread[-3:] < 0.5 * spread[-4:-1]).all())
