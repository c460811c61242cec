"""A fitted model as an arm: the values that the arm file of a re-tuned or corrected model carries."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from stribeck.arm import Arm
from stribeck.effects.placing import entries_of, stated_effects
from stribeck.identify.fitted import arm_with
from stribeck.identify.map_fit import Fit
from stribeck.model.layout import Placed


def arm_of(arm: Arm, fit: Fit, placed: Sequence[Placed]) -> Arm:
    """Return an arm with a fit's values and its effects, and those of its file that no fit has: what reads the records.

    Parameters
    ----------
    arm : Arm
        The nominal one.
    fit : Fit
    placed : sequence of Placed
        Effects with the values found.
    """
    stated = (place for place in stated_effects(arm) if place.effect.direct)
    return replace(arm_with(arm, fit), effects=entries_of(arm, (*placed, *stated)))
