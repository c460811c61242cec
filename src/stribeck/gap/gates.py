"""What an effect must show before the search takes it, and before it keeps it."""

from __future__ import annotations

import numpy as np

from stribeck.gap.model import Model
from stribeck.gap.rank import Ranking
from stribeck.model.layout import Placed

LEAST_T = 2.8  # block-robust t value of the gain
LEAST_GAIN = 0.06  # of the squared residual; held-out runs must show half of it
LEAST_FURTHER = 0.3  # the same for a further effect: less may be what the first one's law does not fit
LARGE_GAIN, SURE = 0.25, 0.99  # a large gain needs no t value where any choice of blocks has it: few may excite it
ELUSIVE_T, ELUSIVE_GAIN = 3.5, 0.2  # for laws that also fit what filters do around rest
ABOVE = 0.7  # of the noise floor's power: less is no gap
FAINT, FAINT_T = 0.35, 4.0  # the same for a large gain of at least such a t value
LEAST_POWER = 0.15  # of the noise floor's power, that an effect removes from a joint whose residual is above it
LEAST_PRIOR = 8.0  # cost that the prior must save for an effect that the residual alone does not show
KEPT_T = 2.0  # block-robust t value below which an effect is dropped again


def earns_its_place(ranking: Ranking, k: int, rival: Model, *, further: bool) -> bool:
    """Return whether the k-th model may be taken: it surely closes some of a gap above the floor; or the prior asks."""
    if strained(rival.placed[-1]):
        return False
    gain, held, t = ranking.overall[k], ranking.gain[k, 0], ranking.t[k]
    before, after = ranking.power[0], ranking.power[k]
    # the floor is known to a factor of 1.5: what is plain may lie below it
    least_power = FAINT if t > FAINT_T and gain > LARGE_GAIN else ABOVE
    above = bool(np.any((before > least_power) & (before - after > LEAST_POWER)))
    large = bool(gain > LARGE_GAIN and ranking.sure[k] > SURE and not further)
    elusive = rival.placed[-1].effect.elusive
    sure = (t > ELUSIVE_T and gain > ELUSIVE_GAIN) if elusive else (t > LEAST_T or large)
    least = LEAST_FURTHER if further else LEAST_GAIN
    # held-out runs that hardly excite the effect cannot confirm it; they must not speak against it
    agreed = held > 0.5 * least or (held > 0.0 and large)
    by_prior = ranking.prior_gain[k] > LEAST_PRIOR and gain > -LEAST_GAIN
    return bool((above and sure and gain > least and agreed) or by_prior)


def needed(ranking: Ranking) -> bool:
    """Return whether the second model, which has one effect more than the first, still earns it."""
    return bool(
        ranking.prior_gain[1] > LEAST_PRIOR
        or (ranking.overall[1] > LEAST_GAIN and (ranking.t[1] > KEPT_T or ranking.sure[1] > SURE))
    )


def strained(place: Placed) -> bool:
    """Return whether an effect's fit rests on a bound of its parameters that is not their null."""
    for parameter in place.effect.parameters:
        value = place.values.get(parameter.name, parameter.null)
        for bound in (parameter.upper,) if parameter.firm else (parameter.lower, parameter.upper):
            if np.isfinite(bound) and bound != parameter.null and abs(value - bound) <= 1e-3 * abs(bound):
                return True
    return False
