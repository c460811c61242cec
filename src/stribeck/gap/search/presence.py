"""How likely an effect that the search took is there: evidence weighed as simulated cases taught.

The weights are those of a logistic regression on 682 effects that searches took, on cases of four plants: the one in
``withheld`` (410) and three that others wrote from the file formats alone (272). They are held by a ridge to those that
248 effects of three of these plants had given. Each of five sets of cases (two of the first plant) foretold by the
others, 491 are named and 448 of them there, where the earlier weights, which had seen some of them, name 500 and 449.
``studies/presence.py`` records new cases and holds these weights against theirs.
"""

from __future__ import annotations

from dataclasses import astuple, dataclass

import numpy as np

from stribeck.gap.search.rank import Ranking
from stribeck.gap.search.step import Step

LEAST_T, MOST_GAIN = 0.3, 0.99  # beyond these, less or more says no more
LEAST_SIZE = 0.05  # of the noise floor's power, below which less is no smaller a gap
FAINT = 0.02  # of it, added to what an effect takes away: the logarithm of next to nothing says no more
CERTAIN = 0.97  # the most that is ever stated: of laws that no library holds, some pass for one that it does


@dataclass(frozen=True)
class Evidence:
    """What speaks for an effect, all others that were taken being there.

    Attributes
    ----------
    t : float
        Logarithm of the block-robust t value of its gain.
    gain : float
        On all runs, -log(1 - gain): equal steps are equal factors of what is left.
    size : float
        Logarithm of the squared residual over the noise floor's without it, at the joint where the effect closes most:
        a gain of so much leaves the more.
    removed : float
        Logarithm of what the effect takes of that joint's squared residual, over the noise floor's: what is faint may
        be the laboratory's, whatever its share of a small gap.
    elusive : float
        1 for a law that also fits what noise and filters do around rest or around no torque.
    elusive_gain : float
        ``gain`` there, else 0.
    left : float
        Logarithm of the residual over the noise floor with everything that was taken, at the joint where most is left;
        at least 0. A law that is not the arm's own leaves some.
    """

    t: float
    gain: float
    size: float
    removed: float
    elusive: float
    elusive_gain: float
    left: float


CENTRE = Evidence(t=2.292, gain=2.489, size=3.621, removed=3.183, elusive=0.144, elusive_gain=0.22, left=0.445)
WEIGHT = Evidence(t=1.0, gain=0.711, size=-0.595, removed=0.668, elusive=-0.4, elusive_gain=1.984, left=-1.744)
LEVEL = 2.299  # log odds at the centre


def presence(seen: Evidence) -> float:
    """Return the probability that an effect with this evidence, or one of its class, is there."""
    away = np.array(astuple(seen)) - np.array(astuple(CENTRE))
    odds = LEVEL + float(away @ np.array(astuple(WEIGHT)))
    return CERTAIN / (1.0 + float(np.exp(-odds)))


def evidence(step: Step, worth: Ranking | None = None) -> Evidence:
    """Return the evidence for what a step of a search took: by its worth, or by its own ranking where none is known.

    Or by another ``worth``, of it and of what else goes with it.
    """
    assert step.best is not None
    elusive = step.best.placed[-1].effect.elusive
    r = step.ranking
    worth = worth or step.worth
    shown, k = (r, r.best) if worth is None else (worth, 1)
    gain = -float(np.log(1.0 - min(shown.overall[k], MOST_GAIN)))
    removed = shown.power[0] - shown.power[k]
    closing = int(np.argmax(removed))
    return Evidence(
        t=float(np.log(max(shown.t[k], LEAST_T))),
        gain=gain,
        size=float(np.log(max(shown.power[0, closing], LEAST_SIZE))),
        removed=float(np.log(max(removed[closing], 0.0) + FAINT)),
        elusive=float(elusive),
        elusive_gain=gain if elusive else 0.0,
        left=0.5 * float(np.log(max(shown.power[k].max(), 1.0))),
    )
