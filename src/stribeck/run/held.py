"""A command that is held from row to row, put on fewer or other rows."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stribeck.run.values import Floats, Run


def on_rows(run: Run, rows: NDArray[np.int_]) -> Run:
    """Return a run with some of its rows alone, and the mean over time of the command from each to the next."""
    edges = np.append(run.t[rows], run.t[-1] + run.sample_time)
    others = ("dq", "q_ref", "dq_ref", "tau_meas", "temperature")
    taken: dict[str, Any] = {name: values[rows] for name in others if (values := getattr(run, name)) is not None}
    tau, droop = mean_of_held(run.t, run.tau, edges)
    return replace(run, t=run.t[rows], q=run.q[rows], tau=tau, droop=droop, extra=None, **taken)


def mean_of_held(t: Floats, values: Floats, edges: Floats) -> tuple[Floats, Floats]:
    """Return the mean over time of a held signal in each of some steps, and what that lacks.

    Parameters
    ----------
    t : array (N,)
        Times, increasing, s, from each of which a value is held to the next, the last one without end.
    values : array (N, n)
    edges : array (M + 1,)
        Times, increasing, s, of the steps' beginnings, none before the first of ``t``, and of the last one's end.

    Returns
    -------
    mean : array (M, n)
        Held from each edge to the next it has the signal's impulse.
    droop : array (M, n)
        Added to the mean, held values follow the signal to the second order of its frequency, not the first alone.

    Notes
    -----
    A change of the signal at a part f of a step is shared by the mean between the step and the next, 1 - f to f: the
    same place in time, but f (1 - f) squared steps too wide. That is twice the first moment of the signal about the
    middle of the step, by whose slope from step to step the width is taken out again.
    """
    knots = np.union1d(edges, t[(t > edges[0]) & (t < edges[-1])])
    held = values[np.searchsorted(t, knots[:-1], "right") - 1]
    first = np.searchsorted(knots, edges[:-1])
    step, length = np.diff(edges), np.diff(knots)
    of_step = np.searchsorted(edges, knots[:-1], "right") - 1
    about = (knots[:-1] + 0.5 * length - 0.5 * (edges[of_step] + edges[of_step + 1])) / step[of_step]
    part = (length / step[of_step])[:, None] * held
    mean, moment = (np.add.reduceat(each, first) for each in (part, about[:, None] * part))
    return mean, -np.gradient(moment, axis=0)
