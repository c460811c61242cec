"""How sure the nominal values of a fitted model are: scatter from block to block, and what noise shifts them by."""

from __future__ import annotations

import numpy as np

from stribeck.gap.answer.margins import FEW_BLOCKS
from stribeck.gap.fitted.differentiable import differentiable
from stribeck.gap.fitted.model import Model, weights_of
from stribeck.gap.records.blocks import block_of_rows
from stribeck.gap.records.prepare import Prepared
from stribeck.identify.confidence import Intervals, intervals
from stribeck.identify.noise_pull import noise_pull
from stribeck.model.path import SignalPath


def nominal_intervals(model: Model, prepared: Prepared, floor: np.ndarray) -> Intervals:
    """Return the 95 % intervals of all of a model's parameters, meant for the nominal ones.

    Those of effects get their margins in :mod:`stribeck.gap.answer.margins`, which were measured without the shift.

    Parameters
    ----------
    model : Model
        Fitted to the fit runs of ``prepared``.
    prepared : Prepared
    floor : array (n,)
        Noise floor of the residual, N m rms.
    """
    fit, weights = model.fit, weights_of(model, prepared, floor)
    path = SignalPath(prepared.arm, model.placed)
    residual = differentiable(path, prepared, prepared.fit, [int(i) for i in fit.free])
    pull = noise_pull(fit, weights, residual, prepared.cutoff)
    return intervals(fit, weights, block_of_rows(prepared.fit), pull=pull, margin=FEW_BLOCKS)
