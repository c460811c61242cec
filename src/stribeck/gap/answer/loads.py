"""What is said where some recordings carry a load at the tip and others do not."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from stribeck.gap.fitted.carrying import LOAD, carrying, unloaded
from stribeck.gap.fitted.model import Model
from stribeck.gap.records.prepare import Prepared


def told_carried(prepared: Prepared, named: Collection[str]) -> list[str]:
    """Return a note on which recordings carry a payload that is named, where others are without."""
    light = unloaded(prepared)
    if LOAD not in named or not light:
        return []
    every = dict.fromkeys(run.name for run in (*prepared.fit, *prepared.held))
    heavy = ", ".join(sorted(name for name in every if name not in light))
    return [f"{LOAD}: in {heavy} only; the corrected arm carries it: take it off where yours does not"]


def told_loads(prepared: Prepared, models: Sequence[Model], floor: np.ndarray, named: Collection[str]) -> list[str]:
    """Return a warning where recordings fall in two groups, by a mass at the tip, by the first model that shows it.

    None where that payload is ``named``.

    Parameters
    ----------
    prepared : Prepared
    models : sequence of Model
        Fitted to its recordings.
    floor : array (n,)
        Noise floor, N m rms.
    named : collection of str
        Effects.
    """
    if LOAD in named and unloaded(prepared):
        return []
    found = next((one for one in (carrying(prepared, model, floor) for model in models) if one), None)
    if found is None:
        return []
    return [
        f"{', '.join(found.loaded)}: as with {found.more:.2g} kg more at the tip than in the other recordings; if they "
        "carry a load, diagnose those with and those without it apart"
    ]
