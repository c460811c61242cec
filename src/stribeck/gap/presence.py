"""How likely an effect that the search took is there: evidence weighed as simulated cases taught.

The weights are those of a logistic regression on 555 effects that searches took, on cases of two plants: the one in
``withheld`` and one that somebody else wrote from the file formats alone. Weights from one plant's cases foretell the
other's as well as they do their own. ``studies/presence.py`` records new cases and holds these weights against theirs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass

import numpy as np

from stribeck.gap.model import Model
from stribeck.gap.search import Step

LEAST_T, MOST_GAIN = 0.3, 0.99  # beyond these, less or more says no more
AT_FLOOR = 1.4  # residual over noise floor up to which nothing is left to explain
CERTAIN = 0.97  # the most that is ever stated: of laws that no library holds, some pass for one that it does


@dataclass(frozen=True)
class Evidence:
    """What speaks for an effect.

    Attributes
    ----------
    t : float
        Logarithm of the block-robust t value of its gain.
    gain : float
        On all runs, -log(1 - gain): equal steps are equal factors of what is left.
    part : float
        How much of the gap above the floor is explained in the end, at the joint where the effect closes most, on the
        held-out or on all runs, whichever is less; 0 to 1.
    clear : float
        Chance against the rivals, those that the gates turned down included.
    further : float
        1 where an earlier step took another effect: what that one's law does not fit may be all there is.
    further_gain : float
        ``gain`` there, else 0.
    """

    t: float
    gain: float
    part: float
    clear: float
    further: float
    further_gain: float


CENTRE = Evidence(t=2.07, gain=1.69, part=0.868, clear=0.973, further=0.097, further_gain=0.084)
WEIGHT = Evidence(t=0.92, gain=0.447, part=2.65, clear=2.46, further=-1.98, further_gain=1.78)
LEVEL = 2.06  # log odds at the centre


def presence(seen: Evidence) -> float:
    """Return the probability that an effect with this evidence, or one of its class, is there."""
    away = np.array(astuple(seen)) - np.array(astuple(CENTRE))
    odds = LEVEL + float(away @ np.array(astuple(WEIGHT)))
    return CERTAIN / (1.0 + float(np.exp(-odds)))


def evidence(taken: Sequence[Step], place: int, floor: np.ndarray) -> Evidence:
    """Return the evidence for what one step of a search took.

    Parameters
    ----------
    taken : sequence of Step
        The steps that took an effect.
    place : int
        Of the step among them.
    floor : array (n,)
        Noise floor of the residual, N m rms.
    """
    step, last = taken[place], taken[-1].best
    assert last is not None
    r = step.ranking
    turned_down = sum(r.probability[k] for k in range(1, len(r.probability)) if k not in {*step.passing, *r.twins()})
    gain = -float(np.log(1.0 - min(r.overall[r.best], MOST_GAIN)))
    return Evidence(
        t=float(np.log(max(r.t[r.best], LEAST_T))),
        gain=gain,
        part=explained(taken[0].base, last, floor, int(np.argmax(r.power[0] - r.power[r.best]))),
        clear=chance(step) * (1.0 - float(turned_down)),
        further=float(place > 0),
        further_gain=gain if place > 0 else 0.0,
    )


def chance(step: Step) -> float:
    """Return the probability of the class that a step took, against the rivals that pass the gates as well."""
    r = step.ranking
    able = sum(r.probability[k] for k in {*step.passing, *r.twins()})
    return float(sum(r.probability[k] for k in r.twins()) / max(able, 1e-12))


def explained(base: Model, final: Model, floor: np.ndarray, joint: int) -> float:
    """Return how much of a joint's gap over the floor is gone, on the held-out or on all runs, whichever is less."""

    def part(before: np.ndarray, after: np.ndarray) -> float:
        first, then = (float(np.mean(r[:, joint] ** 2)) / float(floor[joint]) ** 2 for r in (before, after))
        return 1.0 if first <= 1.0 else float(np.clip(1.0 - max(then - 1.0, 0.0) / (first - 1.0), 0.0, 1.0))

    whole = [np.concatenate([model.fit.residual, model.held]) for model in (base, final)]
    return min(part(base.held, final.held), part(whole[0], whole[1]))
