"""Parts of recordings: evenly spaced ones of those too long to be fitted whole, and those between missing samples."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stribeck.run import Run

MOST_SAMPLES = 300_000  # of all runs together: more adds time and memory, not knowledge
STRETCH = (2.0, 20.0)  # s
FEWEST = 3  # of a run, shorter where need be: at its beginning, middle and end other joints may move
# between missing samples, s and samples: as long as an analysis filter ever is, which takes that much from its ends
LEAST_STRETCH, LEAST_SAMPLES = 0.7, 24


def shortened(runs: Sequence[Run], notes: list[str]) -> list[Run]:
    """Return runs of at most MOST_SAMPLES together: of longer ones, evenly spaced stretches."""
    total = sum(len(run.t) for run in runs)
    if total <= MOST_SAMPLES:
        return list(runs)
    out: list[Run] = []
    for run in runs:
        kept = int(MOST_SAMPLES * len(run.t) / total)
        shortest, longest = (max(16, round(seconds / run.sample_time)) for seconds in STRETCH)
        length = min(max(kept // FEWEST, shortest), longest)
        count = max(kept // length, FEWEST)
        if count * length >= len(run.t):
            out.append(run)
            continue
        starts = np.linspace(0, len(run.t) - length, count).astype(int)
        out += [part(run, start, start + length) for start in starts]
        used = f"{count} stretches of {length * run.sample_time:.3g} s out of {run.duration:.4g} s are used"
        notes.append(f"{run.name}: {used}")
    return out


def between_gaps(runs: Sequence[Run], notes: list[str]) -> list[Run]:
    """Return runs on uniform clocks without what was interpolated across missing samples: the stretches between.

    What is drawn there is no motion: it has no acceleration but at its ends, where it has that of a blow.
    """
    out: list[Run] = []
    for run in runs:
        if run.gaps is None:
            out.append(run)
            continue
        edges = np.flatnonzero(np.diff(np.concatenate([[True], run.gaps, [True]])))
        spans = [(int(start), int(stop)) for start, stop in edges.reshape(-1, 2)]
        longest = max(stop - start for start, stop in spans)
        least = min(max(LEAST_STRETCH / run.sample_time, LEAST_SAMPLES), longest)
        used = [part(run, start, stop) for start, stop in spans if stop - start >= least]
        length = sum(len(one.t) for one in used) * run.sample_time
        notes.append(
            f"{run.name}: {len(used)} stretch{'es' if len(used) > 1 else ''} between missing samples used, "
            f"{length:.3g} s out of {run.duration:.4g} s"
        )
        out += used
    return out


def part(run: Run, start: int, stop: int) -> Run:
    """Return a stretch of a run."""
    keys = ("t", "q", "tau", "dq", "q_ref", "dq_ref", "tau_meas", "temperature", "gaps", "droop")
    cut = {key: getattr(run, key)[start:stop] for key in keys if getattr(run, key) is not None}
    return replace(run, extra=None, **cut)
