"""What a diagnosis lists beside its answer: every candidate that was tried, and the torques that were compared."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stribeck.gap.fitted.model import Model
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.records.regions import analysis_signals
from stribeck.gap.result import Candidate, Estimate, Trace
from stribeck.gap.search.step import Step


def candidates_of(steps: Sequence[Step], names: Sequence[str]) -> tuple[Candidate, ...]:
    """Return a row for every candidate of every step, those that were screened out included.

    Parameters
    ----------
    steps : sequence of Step
        Of the search.
    names : sequence of str
        Of the joints.
    """
    rows = []
    for number, step in enumerate(steps, 1):
        for k, model in enumerate(step.rivals, 1):
            place, gain = model.placed[-1], step.ranking.gain[k]
            chosen = step.taken and k == step.ranking.best
            estimate = Estimate(float(gain[0]), float(gain[1]), float(gain[2]))
            t, where = float(step.ranking.t[k]), ", ".join(names[j] for j in place.joints(len(names)))
            rows.append(Candidate(number, place.effect.name, where, estimate, t, model.fit.status, chosen))
        nothing = Estimate(np.nan, np.nan, np.nan)
        rows.extend(
            Candidate(number, effect, names[joint], nothing, np.nan, "screened out")
            for effect, joint in step.screened_out
        )
    return tuple(rows)


def traces_of(prepared: Prepared, given: np.ndarray, base: Model, final: Model) -> tuple[Trace, ...]:
    """Return measured and modelled torque of each held-out run.

    Parameters
    ----------
    prepared : Prepared
    given : array (M, n)
        Residual of the model as given on the held-out runs, N m.
    base, final : Model
        Re-tuned, and with the named effects.
    """
    signals = analysis_signals(prepared.held)
    traces = []
    start = 0
    for run in prepared.held:
        rows = slice(start, start + len(run.analysis_index))
        start = rows.stop
        measured = signals["command"][rows]
        traces.append(
            Trace(
                run.name,
                signals["time"][rows],
                signals["position"][rows],
                signals["velocity"][rows],
                measured,
                measured - given[rows],
                measured - base.held[rows],
                measured - final.held[rows],
            )
        )
    return tuple(traces)
