"""What an effect must show before the search takes it, and before it keeps it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stribeck.gap.model import Model
from stribeck.gap.rank import Ranking
from stribeck.model.layout import Placed
from stribeck.model.values import Scale

LEAST_T = 2.8  # block-robust t value of the gain
SMALL_GAIN, SMALL_T = 0.15, 6.0  # a smaller gain needs a larger t value: filters leave some of that kind
LEAST_GAIN = 0.06  # of the squared residual; held-out runs must show half of it
LEAST_FURTHER = 0.25  # the same for a further effect at a joint: less may be what the first one's law does not fit
LEAST_ELSEWHERE = 0.15  # the same where the joint has no effect yet, but another one has
LARGE_GAIN, SURE = 0.25, 0.99  # a large gain needs no t value where any choice of blocks has it: few may excite it
PLAIN_T, PLAIN_GAIN = 4.0, 0.2  # from which held-out runs that hardly excite an effect need not confirm it
ELUSIVE_T, ELUSIVE_GAIN = 3.5, 0.2  # for laws that also fit what filters do around rest
ELUSIVE_HELD = 0.4  # gain on the held-out runs alone that makes up for a lower t value
WELL_ABOVE, WELL_CLOSED = 2.0, 0.35  # of the noise floor's power, or of the squared residual, that they must show
CLEAR_T, CLEAR_GAIN = 5.0, 0.1  # t value, and gain there and on all runs, that make up for a smaller gain
NOTHING = -0.02  # gain on held-out runs that says neither yes nor no
ABOVE = 0.7  # of the noise floor's power: less is no gap
FAINT, FAINT_T = 0.35, 4.0  # the same for a large gain of at least such a t value
LEAST_POWER = 0.15  # of the noise floor's power, that an effect removes from a joint whose residual is above it
LEAST_PRIOR = 8.0  # cost that the prior must save for an effect that the residual alone does not show
MOST_PRIOR = 4.0  # cost to the prior that a law may ask for: more, and it is the nominal values that it bends
KEPT_T = 2.0  # block-robust t value below which an effect is dropped again


def earns_its_place(
    ranking: Ranking, k: int, rival: Model, scales: Sequence[Scale], taken: Sequence[Placed] = ()
) -> bool:
    """Return whether the k-th model may be taken: it surely closes some of a gap above the floor; or the prior asks.

    Parameters
    ----------
    scales : sequence of Scale
        Typical magnitudes of each joint.
    taken : sequence of Placed
        Effects that earlier steps of the search have taken.
    """
    new = rival.placed[-1]
    if strained(new) or not new.effect.plausible(new.values, scales[new.joint]):
        return False
    gain, held, t = ranking.overall[k], ranking.gain[k, 0], ranking.t[k]
    before, after = ranking.power[0], ranking.power[k]
    # the floor is known to a factor of 1.5: what is plain may lie below it
    least_power = FAINT if t > FAINT_T and gain > LARGE_GAIN else ABOVE
    above = bool(np.any((before > least_power) & (before - after > LEAST_POWER)))
    surely = bool(ranking.sure[k] > SURE)
    large = bool(gain > LARGE_GAIN and surely and not taken)
    if new.effect.elusive:
        above = above and (before[new.joint] > WELL_ABOVE or gain > WELL_CLOSED)
        sure = gain > ELUSIVE_GAIN and (t > ELUSIVE_T or (held > ELUSIVE_HELD and surely))
        sure = sure or (t > CLEAR_T and min(gain, held) > CLEAR_GAIN)
    else:
        sure = (t > LEAST_T and (gain > SMALL_GAIN or t > SMALL_T)) or large
    closing = int(np.argmax(before - after))  # the coupling may close a gap at another joint than its own
    here = any(place.joint in (new.joint, closing) for place in taken)
    least = LEAST_FURTHER if here else LEAST_ELSEWHERE if taken else LEAST_GAIN
    # held-out runs that hardly excite the effect cannot confirm it; they must not speak against it
    agreed = held > 0.5 * least or (held > NOTHING and (large or (t > PLAIN_T and gain > PLAIN_GAIN)))
    by_prior = new.effect.rescales and ranking.prior_gain[k] > LEAST_PRIOR and gain > -LEAST_GAIN
    bearable = ranking.prior_gain[k] > -MOST_PRIOR or gain > 2.0 * LARGE_GAIN
    return bool((above and sure and gain > least and agreed and bearable) or by_prior)


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
