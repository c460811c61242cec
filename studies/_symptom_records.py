"""The symptoms that the records show by themselves: a velocity that trails, a coarse encoder."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from _symptom_cases import Case
from _symptom_values import Array, Points, Symptom
from scipy.signal import lfilter

from stribeck.gap.records.prepare import Prepared
from stribeck.identify.conditioning import Conditioned
from stribeck.model.effect import Effect
from stribeck.model.values import Record
from stribeck.run import Run

WIDE, STEPS = 250, 6.0  # samples of the stretch in which a coarse encoder is drawn, and steps that it passes there


def record_symptom(effect: Effect, case: Case) -> Symptom:
    """Return the points in which the symptom of a ``direct`` effect shows."""
    runs = case.runs.fit
    resolution = case.runs.arm.joints[0].encoder_resolution
    velocities = tuple(np.asarray(run.run.dq)[:, 0] for run in runs)
    steps = tuple(run.run.sample_time for run in runs)
    seen = effect.observed(Record(tuple(run.run.q[:, 0] for run in runs), velocities, steps, resolution))
    assert seen is not None
    value = next(iter(seen.values.values()))[0]
    return (_late_velocity if effect.shows == "recorded velocity" else _coarse_position)(case, value)


def _late_velocity(case: Case, time: float) -> Symptom:
    def points(runs: Prepared, late: float) -> Points:
        parts = [_trailing(run, late) for run in runs.fit]
        x, y, law = (np.concatenate([part[k] for part in parts]) for k in range(3))
        side = np.concatenate([np.sign(run.velocity[run.analysis_index, 0]) for run in runs.fit])
        return Points(x, y, law if late else None, side)

    label = "recorded velocity less slope of the position, rad/s"
    return Symptom(points(case.bare, 0.0), points(case.runs, time), "acceleration, rad/s²", label)


def _trailing(run: Conditioned, time: float) -> tuple[Array, Array, Array]:
    """Return acceleration, recorded velocity less the position's slope, and the same of a slope that lags by a time."""
    slope = run.velocity[:, 0]
    every = round(run.sample_time / run.run.sample_time)
    keep = float(np.exp(-run.sample_time / time)) if time else 0.0
    lagged = lfilter([1.0 - keep], [1.0, -keep], slope, zi=[slope[0] * keep])[0]
    seen = np.asarray(run.run.dq)[::every, 0]
    columns = np.stack([run.acceleration[:, 0], seen - slope, lagged - slope], axis=1)
    return tuple(run.filtered(columns).T)  # type: ignore[return-value]


def _coarse_position(case: Case, step: float) -> Symptom:
    """Draw the stretch in which the joint passes some steps most evenly, against its smooth course."""
    k, begin = _even_stretch([run.run for run in case.runs.fit], step)

    def points(runs: Prepared, law: bool) -> Points:
        run = runs.fit[k].run
        course, left = _course(run, begin)
        rounded = step * np.round(course / step) - course
        return Points(course, left, rounded if law else None, np.ones(WIDE))

    label = "recorded position less its smooth course, rad"
    return Symptom(points(case.bare, False), points(case.runs, True), "position, rad", label, None, joined=True)


def _course(run: Run, begin: int) -> tuple[Array, Array]:
    """Return a cubic through a stretch of the position record, and what the record has beside it, rad."""
    t, q = run.t[begin : begin + WIDE], run.q[begin : begin + WIDE, 0]
    course = np.polynomial.Polynomial.fit(t, q, 3)(t)
    return course, q - course


def _even_stretch(runs: Sequence[Run], step: float) -> tuple[int, int]:
    """Return run and sample at which a stretch begins that passes so many steps and is nearest to a cubic."""
    found = []
    for k, run in enumerate(runs):
        for begin in range(0, len(run.t) - WIDE, WIDE // 4):
            moved = abs(run.q[begin + WIDE - 1, 0] - run.q[begin, 0]) / step
            if STEPS <= moved <= 2.0 * STEPS:
                found.append((float(np.std(_course(run, begin)[1])), k, begin))
    _, k, begin = min(found)
    return k, begin
