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
    prepared : Prepared
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
    warnings = []
    for joint in _joints(recordings):
        rows = _ordered(recordings, joint)
        if len(rows) < LEAST:
            continue
        (left, worst), (next_to_it, _) = rows[:2]
        if left > ALONE * max(next_to_it, 1.0):
            warnings.append(
                f"{worst.run}: {joint} leaves {left:.2g} times its noise there and {next_to_it:.2g} "
                "times at most in the others; if that recording is of another load, setting or arm, leave it out"
            )
    return warnings


def held_alone(recordings: Sequence[Recording]) -> list[str]:
    """Return the recordings, at most one a joint, that are held out though they leave far more than all fitted ones."""
    return list(dict.fromkeys(row.run for row, _ in _unlearnt(recordings)))


def alike_now(before: Sequence[Recording], after: Sequence[Recording]) -> bool:
    """Return whether none is left with far more than the fitted ones had before, where one held out stood out."""
    return all(_ordered(after, row.joint)[0][0] < most for row, most in _unlearnt(before))


def _unlearnt(recordings: Sequence[Recording]) -> Iterator[tuple[Recording, float]]:
    """Yield what is held out and leaves most at a joint, where that is more than ``most``, which is told along.

    ``most`` is what would be far more than the fitted ones leave there, in noise.
    """
    for joint in _joints(recordings):
        rows = _ordered(recordings, joint)
        most = ALONE * max([1.0, *(left for left, row in rows if not row.held_out)])
        if rows and rows[0][0] > most:
            yield rows[0][1], most


def _joints(recordings: Sequence[Recording]) -> list[str]:
    return list(dict.fromkeys(row.joint for row in recordings))


def _ordered(recordings: Sequence[Recording], joint: str) -> list[tuple[float, Recording]]:
    """Return the recordings of a joint with what each leaves over its noise, the largest first."""
    rows = [row for row in recordings if row.joint == joint and row.noise > 0.0]
    return sorted(((row.corrected / row.noise, row) for row in rows), key=lambda pair: -pair[0])
