"""What each recording by itself leaves: a gap that one of many shows may be its own, not the arm's."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from stribeck.gap.fitted.model import Model
from stribeck.gap.fitted.noisy import put_back
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.records.spread import noise_power
from stribeck.gap.result import Recording

LEAST = 3  # recordings, of which one may stand alone: of two, either does
ALONE = 4.0  # times what the noisiest of the others leaves over its noise: so much more has a cause of its own


def recordings_of(prepared: Prepared, base: Model, final: Model, floor: np.ndarray) -> tuple[Recording, ...]:
    """Return a row for every recording and joint, fitted ones first, parts of one recording taken together.

    Parameters
    ----------
    base, final : Model
        Re-tuned, and with the named effects.
    floor : array (n,)
        Noise floor on the held-out runs, N m rms; what it has beyond the known noise of the rows is spread evenly.
    """
    runs = (*prepared.fit, *prepared.held)
    kept_back = [False] * len(prepared.fit) + [True] * len(prepared.held)
    keys = [(run.name, held) for run, held in zip(runs, kept_back, strict=True)]
    key_of_row = np.repeat(np.arange(len(runs)), [len(run.analysis_index) for run in runs])
    before, after = (put_back(prepared, model.whole, model.noise, floor) for model in (base, final))
    noise = noise_power(prepared.noise, floor, len(before), base.rows)
    out = []
    for name, held in dict.fromkeys(keys):
        rows = np.isin(key_of_row, [i for i, key in enumerate(keys) if key == (name, held)])
        rms = [np.sqrt(np.mean(squares[rows], axis=0)) for squares in (before**2, after**2, noise)]
        for j, joint in enumerate(prepared.arm.names):
            out.append(Recording(name, held, joint, *(float(values[j]) for values in rms)))
    return tuple(out)


def told_alone(recordings: Sequence[Recording]) -> list[str]:
    """Return a warning for each joint where one recording alone leaves far more over its noise than all others."""
    return [
        f"{row.run}: {row.joint} leaves {left:.2g} times its noise there and {most:.2g} "
        "times at most in the others; if that recording is of another load, setting or arm, leave it out"
        for row, left, most in _alone(recordings)
    ]


def held_alone(recordings: Sequence[Recording]) -> list[str]:
    """Return the recordings that are held out though, at some joint, they alone leave far more than all others."""
    return list(dict.fromkeys(row.run for row, _, _ in _alone(recordings) if row.held_out))


def alike_now(before: Sequence[Recording], after: Sequence[Recording]) -> bool:
    """Return whether no recording is left with far more than all but the one that stood alone had before."""
    joints = dict.fromkeys(row.joint for row, _, _ in _alone(before))
    return all(_ordered(after, joint)[0][0] < ALONE * max(_ordered(before, joint)[1][0], 1.0) for joint in joints)


def _alone(recordings: Sequence[Recording]) -> Iterator[tuple[Recording, float, float]]:
    """Yield what stands alone at a joint: how much it leaves over its noise, and the next to it."""
    for joint in dict.fromkeys(row.joint for row in recordings):
        found = _ordered(recordings, joint)
        if len(found) < LEAST:
            continue
        (left, worst), (next_to_it, _) = found[:2]
        if left > ALONE * max(next_to_it, 1.0):
            yield worst, left, next_to_it


def _ordered(recordings: Sequence[Recording], joint: str) -> list[tuple[float, Recording]]:
    """Return the recordings of a joint with what each leaves over its noise, the largest first."""
    rows = [row for row in recordings if row.joint == joint and row.noise > 0.0]
    return sorted(((row.corrected / row.noise, row) for row in rows), key=lambda pair: -pair[0])
