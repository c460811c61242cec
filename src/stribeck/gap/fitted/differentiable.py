"""A residual that a fit can follow downhill: with secants, and how wide they are, where derivatives mislead."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from stribeck.gap.fitted.sizes import effect_scales
from stribeck.gap.records.prepare import Prepared
from stribeck.identify.conditioning import Conditioned
from stribeck.identify.residual import Residual
from stribeck.identify.secants import Secants
from stribeck.identify.shifted import Shifted
from stribeck.model.layout import Entry
from stribeck.model.path import SignalPath
from stribeck.model.values import IN_TIME, OVER_POSITION

PHASE_STEP = 0.15  # rad, by which a wave may turn from end to end of what it is seen along
NOMINAL_STEP = 0.5  # standard deviations of a nominal value, half the width of its secant where one is taken
SHIFT_STEP = (0.05, 0.1)  # of the period of the analysis cutoff, by which a secant moves a record: near and far


def differentiable(
    path: SignalPath,
    prepared: Prepared,
    runs: Sequence[Conditioned],
    columns: Sequence[int] | None = None,
    *,
    observe: bool = True,
    far: bool = False,
) -> Residual:
    """Return the residual of a path along runs for a fit; with secants where its derivatives would mislead.

    What starts ``far`` from its end has wider ones: they lead from further, and end less near.

    Parameters
    ----------
    path : SignalPath
    prepared : Prepared
        Tells the scales of the parameters, and the cutoff.
    runs : sequence of Conditioned
    columns : sequence of int or None
        Parameters whose derivatives are wanted; those that a fit may move where None.
    observe : bool
        As of :class:`Residual`.
    far : bool
        Whether the fit starts far from its end.
    """
    if path.shifts and not path.rough:
        shifts = dict.fromkeys(path.shifts, SHIFT_STEP[far] / prepared.cutoff)
        return Shifted(path, runs, shifts, columns, observe=observe)
    if not path.rough:
        return Residual(path, runs, columns, observe=observe)
    scales = effect_scales(path, prepared)
    steps = [_step(path, entry, scales, prepared) for entry in path.entries]
    for i in path.shifts:
        steps[i] = SHIFT_STEP[far] / prepared.cutoff
    return Secants(path, runs, np.array(steps), columns, observe=observe)


def _step(path: SignalPath, entry: Entry, scales: Mapping[str, float], prepared: Prepared) -> float:
    """Return half a secant's width: relative for a logarithm."""
    if entry.log:
        return path.rough
    if np.isfinite(entry.sd):
        return NOMINAL_STEP * entry.sd
    if entry.unit == IN_TIME:  # a wave is a line for a part of a radian only
        return PHASE_STEP / (2.0 * np.pi * max(run.run.duration for run in prepared.fit))
    if entry.unit in OVER_POSITION:
        return PHASE_STEP / prepared.scales[entry.joint].travel
    return path.rough * scales[entry.key]
