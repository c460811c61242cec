"""Intervals of effect parameters: what the blocks say, and what a law that is not exact adds to it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from stribeck.gap.result import Estimate

NORMAL = 1.96
FORM = 0.03  # standard deviation, over a parameter's size, of what the arm's law and ours call by the same name
COUNTED = {"1/rad": 0.005, "1/m": 0.005, "Hz": 0.001}  # the same of waves, whose number no law's shape alters
FEW_BLOCKS = 1.3  # by which the intervals of 150 parameters of recordings with a known truth were too narrow
OF_A_SAMPLE = 0.05  # standard deviation of a time, in samples: how well interpolation places an instant


def widened(
    found: Mapping[str, Estimate], bounds: Mapping[str, tuple[float, float]], sample_time: float
) -> dict[str, Estimate]:
    """Return one joint's parameters of an effect with the intervals that hold.

    Parameters
    ----------
    found : mapping of str to Estimate
        With the intervals of the fit.
    bounds : mapping of str to tuple of float
        Between which each parameter can lie: a stiffness has a sign, the sine of a wave has none.
    sample_time : float
        Of the recordings, s.
    """
    together = list(found.values())
    return {name: _within(_widened(one, together, sample_time), *bounds[name]) for name, one in found.items()}


def _within(estimate: Estimate, lower: float, upper: float) -> Estimate:
    low, high = max(estimate.low, lower), min(estimate.high, upper)
    return replace(estimate, low=min(low, estimate.value), high=max(high, estimate.value))


def _widened(estimate: Estimate, together: Sequence[Estimate], sample_time: float) -> Estimate:
    # the sine and cosine of one wave share its amplitude
    size = math.hypot(*(other.value for other in together if other.unit == estimate.unit))
    instant = OF_A_SAMPLE * sample_time if estimate.unit == "s" else 0.0
    form = NORMAL * math.hypot(COUNTED.get(estimate.unit, FORM) * size, instant)
    low = estimate.value - math.hypot(FEW_BLOCKS * (estimate.value - estimate.low), form)
    high = estimate.value + math.hypot(FEW_BLOCKS * (estimate.high - estimate.value), form)
    return replace(estimate, low=low, high=high)
