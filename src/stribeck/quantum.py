"""The grid that a record of positions lies on: an encoder's step, read off the record itself."""

from __future__ import annotations

import numpy as np

RESTING = 1e-12  # rad, up to which a record has not moved
LEAST_STEPS = 8  # of a record, that show a grid
NEAR = 0.125  # of a quantum: nearer to a grid lie few values of a record that is on none
UNEVEN = 0.1  # of its steps, after which a count goes on by more or less


def smallest_step(*records: np.ndarray) -> tuple[float, float]:
    """Return the quantum of some records (rad) and by how much it may be off; 0, 0 where they lie on no grid.

    A record that rests shows no grid, and says nothing against it. One that never moves slowly steps over many quanta
    at a time; of all values that it takes, some lie a quantum apart. Equal steps, sample after sample, are no grid but
    a constant speed: an encoder's count goes on now and then, or by one more or less.
    """
    moving = [record for record in records if np.ptp(record) > RESTING]
    if not moving:
        return 0.0, 0.0
    steps = np.concatenate([np.abs(np.diff(record)) for record in moving])
    apart = np.concatenate([np.diff(np.unique(record)) for record in moving])
    rounded, printed = (max(map(told, moving)) for told in (rounding, _printed))
    if np.sum(steps > RESTING) < LEAST_STEPS:
        return 0.0, 0.0
    for gaps in (steps, apart):
        quantum, off = _fitted(moving, steps, float(np.quantile(gaps[gaps > RESTING], 0.01)))
        counted = np.round(steps / quantum)
        uneven = np.sum(np.diff(counted) != 0.0) > UNEVEN * np.sum(counted > 0.0)
        near = max(rounded, min(printed, NEAR * quantum))
        if np.mean(off > near) < 0.05 and uneven:
            return quantum, near
    return 0.0, 0.0


def _fitted(records: list[np.ndarray], steps: np.ndarray, quantum: float) -> tuple[float, np.ndarray]:
    """Return a quantum, fitted to the steps and then to all values, and how far these (M,) lie off its grid."""
    multiples = np.round(steps / quantum)
    quantum = float(multiples @ steps / (multiples @ multiples))
    values = np.concatenate([record - np.mean(record) for record in records])
    places = [np.round((record - record[0]) / quantum) for record in records]
    centred = np.concatenate([place - np.mean(place) for place in places])
    quantum = float(centred @ values / max(centred @ centred, 1.0))
    off = [record - quantum * place for record, place in zip(records, places, strict=True)]
    return quantum, np.abs(np.concatenate([one - np.median(one) for one in off]))


def rounding(record: np.ndarray) -> float:
    """Return by how much a record's values may be rounded, rad: as printed with few digits, or in single precision."""
    for digits in range(3, 13):
        if np.all(np.abs(record - np.round(record, digits)) < 1e-14 + 4.0 * np.spacing(np.abs(record))):
            return float(0.6 * 10.0**-digits)
    return float(2.0 * np.max(np.abs(record)) * np.finfo(np.float32).eps)


def _printed(record: np.ndarray) -> float:
    """Return by how much a record's largest values may be rounded, rad, where all have as many significant digits."""
    values = np.abs(record[record != 0.0])
    first = np.floor(np.log10(values))
    for digits in range(3, 13):
        unit = 10.0 ** (first - digits + 1)
        if np.all(np.abs(values - unit * np.round(values / unit)) < 4.0 * np.spacing(values)):
            return float(0.6 * unit.max())
    return 0.0
