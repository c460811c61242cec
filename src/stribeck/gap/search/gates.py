"""What an effect must show before the search takes it, and before it keeps it.

These bars are low: what was taken is weighed in ``presence``, and named only where that makes it likely enough.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from stribeck.gap.fitted.model import Model
from stribeck.gap.search.random_torque import Randomness
from stribeck.gap.search.rank import Ranking
from stribeck.model.effect import ActuatorEffect
from stribeck.model.layout import Placed
from stribeck.model.scale import Scale

LEAST_T = 2.8  # block-robust t value of the gain
LEAST_GAIN = 0.05  # of the squared residual; held-out runs must show half of it
LEAST_FURTHER = 0.15  # the same for a further effect at a joint: less may be what the first one's law does not fit
LEAST_OF_RANDOM = 0.25  # the same of random torque, for a filter: less is how the loop answers to what shakes the arm
FORETOLD = 0.25  # of what a filter closes there, that motion must foretell of it: the rest is its answer to what shakes
LARGE_GAIN, SURE = 0.25, 0.99  # a large gain needs no t value where any choice of blocks has it: few may excite it
FURTHER_GAIN, FURTHER_T = 0.5, 2.0  # the same for a further effect at a joint, which needs some t value
PLAIN_T, PLAIN_GAIN = 4.0, 0.2  # from which held-out runs that hardly excite an effect need not confirm it
MOST_LOST = 0.1  # of what fitted runs gain, that held-out ones may lose to it
LEAST_POWER = 0.1  # of the noise floor's power, that an effect removes from a joint
NOISE = 1.2  # of it, up to which there is but noise, of which a filter takes some
LEAST_PRIOR = 8.0  # cost that the prior must save for an effect that the residual alone does not show
MOST_PRIOR = 4.0  # cost to the prior that a law may ask for: more, and it is the nominal values that it bends
KEPT_T = 2.0  # block-robust t value below which an effect is dropped again


def earns_its_place(
    ranking: Ranking,
    k: int,
    rival: Model,
    scales: Sequence[Scale],
    taken: Sequence[Placed] = (),
    random: Mapping[int, Randomness] | None = None,
) -> bool:
    """Return whether the k-th model may be taken: it surely closes some of the gap; or the prior asks for it.

    Parameters
    ----------
    ranking : Ranking
    k : int
        The model's place in it; the base has 0.
    rival : Model
        That model.
    scales : sequence of Scale
        Typical magnitudes of each joint.
    taken : sequence of Placed
        Effects that earlier steps of the search have taken.
    random : mapping of int to Randomness, or None
        Joints at which what the base model leaves is random.
    """
    new = rival.placed[-1]
    if not holds(new, scales[new.joint]):
        return False
    gain, held, t = ranking.overall[k], ranking.gain[k, 0], ranking.t[k]
    removed = ranking.power[0] - ranking.power[k]
    closing = int(np.argmax(removed))  # the coupling may close a gap at another joint than its own
    if isinstance(new.effect, ActuatorEffect) and closing != new.joint and not scales[closing].driven:
        return False  # of a joint without a drive the equations hold at any scale, and less of everything leaves less
    here = any(place.joint in (new.joint, closing) for place in taken)
    large = bool(gain > LARGE_GAIN and ranking.sure[k] > SURE and (not here or (gain > FURTHER_GAIN and t > FURTHER_T)))
    least = LEAST_FURTHER if here else LEAST_GAIN
    left = random.get(closing) if random and new.effect.filters else None
    if left:
        least = LEAST_OF_RANDOM
        if 1.0 - left.share < FORETOLD * gain:
            return False
    # held-out runs that hardly excite the effect cannot confirm it; they must not speak against it
    spared = ranking.lost[k] < MOST_LOST and (large or (t > PLAIN_T and gain > PLAIN_GAIN))
    noise = new.effect.filters and ranking.power[0, closing] <= NOISE
    shown = gain > least and removed[closing] > LEAST_POWER and not noise and (t > LEAST_T or large)
    by_prior = new.effect.rescales and ranking.prior_gain[k] > LEAST_PRIOR and gain > -LEAST_GAIN
    bearable = ranking.prior_gain[k] > -MOST_PRIOR or gain > LARGE_GAIN
    return bool((shown and bearable and (held > 0.5 * least or spared)) or by_prior)


def needed(ranking: Ranking) -> bool:
    """Return whether the second model, which has one effect more than the first, still earns it."""
    return bool(
        ranking.prior_gain[1] > LEAST_PRIOR
        or (ranking.overall[1] > LEAST_GAIN and (ranking.t[1] > KEPT_T or ranking.sure[1] > SURE))
    )


def holds(place: Placed, scale: Scale) -> bool:
    """Return whether an effect's values are plausible at its joint, and none rests on a bound."""
    return place.effect.plausible(place.values, scale) and not strained(place, scale)


def strained(place: Placed, scale: Scale | None = None) -> bool:
    """Return whether an effect's fit rests on a bound of its parameters that is not their null, nor as good as it.

    Places are bounded about the middle of the joint's motion, as ``scale`` has it.
    """
    for parameter in place.effect.parameters:
        lower, upper = parameter.bounds(scale.middle if scale else 0.0)
        value = place.values.get(parameter.name, parameter.null)
        none = parameter.log and parameter.null == 0.0  # which has no logarithm: the lower bound stands for it
        for bound in (upper,) if parameter.firm or none else (lower, upper):
            near = 1e-3 * (parameter.reach if parameter.place else abs(bound))
            if np.isfinite(bound) and bound != parameter.null and abs(value - bound) <= near:
                return True
    return False
