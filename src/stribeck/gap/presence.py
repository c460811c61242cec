"""How likely an effect that the search took is there: evidence weighed as simulated cases taught.

The weights are those of a logistic regression on 237 effects that searches took, on cases of two plants: the one in
``withheld`` and one that somebody else wrote from the file formats alone. Weights from one plant's cases foretell the
other's as well as they do their own. ``studies/presence.py`` records new cases and holds these weights against theirs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass

import numpy as np

from stribeck.gap.search import Step

LEAST_T, MOST_GAIN = 0.3, 0.99  # beyond these, less or more says no more
LEAST_SIZE = 0.05  # of the noise floor's power, below which less is no smaller a gap
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
    size : float
        Logarithm of the squared residual over the noise floor's before, at the joint where the effect closes most: a
        gain of so much leaves the more.
    clear : float
        Chance against the rivals, those that the gates turned down included.
    further : float
        1 where an earlier step took another effect: what that one's law does not fit may be all there is.
    elusive : float
        1 for a law that also fits what noise and filters do around rest.
    elusive_gain : float
        ``gain`` there, else 0.
    """

    t: float
    gain: float
    size: float
    clear: float
    further: float
    elusive: float
    elusive_gain: float


CENTRE = Evidence(t=2.0, gain=1.68, size=2.64, clear=0.949, further=0.241, elusive=0.177, elusive_gain=0.061)
WEIGHT = Evidence(t=0.817, gain=0.861, size=-0.492, clear=1.58, further=-1.48, elusive=-2.06, elusive_gain=4.55)
LEVEL = 0.73  # log odds at the centre


def presence(seen: Evidence) -> float:
    """Return the probability that an effect with this evidence, or one of its class, is there."""
    away = np.array(astuple(seen)) - np.array(astuple(CENTRE))
    odds = LEVEL + float(away @ np.array(astuple(WEIGHT)))
    return CERTAIN / (1.0 + float(np.exp(-odds)))


def evidence(taken: Sequence[Step], place: int) -> Evidence:
    """Return the evidence for what one step of a search took.

    Parameters
    ----------
    taken : sequence of Step
        The steps that took an effect.
    place : int
        Of the step among them.
    """
    step = taken[place]
    assert step.best is not None
    elusive = step.best.placed[-1].effect.elusive
    r = step.ranking
    turned_down = sum(r.probability[k] for k in range(1, len(r.probability)) if k not in {*step.passing, *r.twins()})
    gain = -float(np.log(1.0 - min(r.overall[r.best], MOST_GAIN)))
    closing = int(np.argmax(r.power[0] - r.power[r.best]))
    return Evidence(
        t=float(np.log(max(r.t[r.best], LEAST_T))),
        gain=gain,
        size=float(np.log(max(r.power[0, closing], LEAST_SIZE))),
        clear=chance(step) * (1.0 - float(turned_down)),
        further=float(place > 0),
        elusive=float(elusive),
        elusive_gain=gain if elusive else 0.0,
    )


def chance(step: Step) -> float:
    """Return the probability of the class that a step took, against the rivals that pass the gates as well."""
    r = step.ranking
    able = sum(r.probability[k] for k in {*step.passing, *r.twins()})
    return float(sum(r.probability[k] for k in r.twins()) / max(able, 1e-12))
