"""Effects that may only fill in what a stronger one's law leaves of its own phenomenon.

Nature keeps to no library: a friction that is higher at one spot is not quite a wave over position, and a ripple takes
what the wave leaves. Two kinds of lateness, or two waves, hardly ever meet in one joint; one that is no pure pole does.
But what fills in leaves some in turn: one that ends at the noise what another one left is there. Not so a curve over
position, for two waves bend like any, nor a second lateness of one channel: a pole and a delay make up most third ones.
An edge bends like no wave: laid over one, with line and constant re-tuned, it leaves a thirtieth of it at least. Nor
does a wall in the way of the tip, which pushes at all joints by where they all are, make up a curve with one that is
felt at a single joint. Nor does a wave of many periods bend like a curve, so it is no kin of one.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from stribeck.gap.search.step import Step
from stribeck.model.effect import Effect
from stribeck.model.layout import Placed
from stribeck.model.scale import Scale

WAVE = {"wave"}
ENDING = WAVE | {"speed"}  # kinds of which only what is there ends at the noise what another one left
ACROSS = {"late"}  # the same, where the other one is of another channel
BENT = {"curve"}  # the same, of an edge and a wave, and of laws that are not felt at the same joints
SLIGHT = WAVE | {"curve"}  # kinds of which what every arm has leaves nothing to fill in
ENDED = 0.1  # of what such a one leaves beyond the noise: the most that may be left beside another that is there too
EDGED = 0.02  # the same, of an edge and a wave
FILLING = 0.5  # of the presence: of seven that came after their kin on cases of two plants, none was there


def filling_in(steps: Sequence[Step], scales: Sequence[Scale]) -> list[bool]:
    """Return, for steps that each took an effect, whether it is kin to one that takes more at its joint.

    Kin to what is there already and no more than every arm has (``gap.search.ordinary``), it may fill in as well; but a
    wave or a curve of a per cent leaves less than any cause takes.
    """
    found = [(step.best.placed[-1], _taken(step)) for step in steps if step.best is not None]
    before = steps[0].base.placed if steps else ()
    known = [place for place in before if place.effect.ordinary(place.values, scales[place.joint])]
    return [
        any(
            taken.size < more.size and _kin(mine, other, scales) - _ended(mine, other, taken, len(scales))
            for other, more in found
        )
        or any(_kin(mine, other, scales) - SLIGHT for other in known)
        for mine, taken in found
    ]


def simpler_than(effect: Effect, others: Sequence[Effect]) -> bool:
    """Return whether one that does as well has fewer parameters and is no kin: such a one fills in nothing."""
    return any(len(o.parameters) < len(effect.parameters) and not set(o.kin) & set(effect.kin) for o in others)


def _kin(one: Placed, other: Placed, scales: Sequence[Scale]) -> set[str]:
    """Return the kinds that two effects share at one joint."""
    if one.joint != other.joint:
        return set()
    first, second = (set(place.effect.phenomena(place.values, scales[place.joint])) for place in (one, other))
    return first & second


def _ended(one: Placed, other: Placed, taken: _Taken, joints: int) -> set[str]:
    """Return the kinds in which one that ends at the noise what another left fills in nothing; none where it does not.

    A drive and a record that are late are two.
    """
    if taken.left > ENDED:
        return set()
    kinds = ENDING if one.effect.channel == other.effect.channel else ENDING | ACROSS
    waves = any("wave" in place.effect.kin for place in (one, other))
    edged = any(a.effect.edged and "wave" in b.effect.kin for a, b in ((one, other), (other, one)))
    # the joints at which only one of them is felt tell the two apart: nothing may be left there, either
    apart = one.joints(joints) != other.joints(joints) and not waves and taken.anywhere < ENDED
    return kinds | BENT if apart or (edged and taken.left < EDGED) else kinds


class _Taken(NamedTuple):
    """What an effect takes of the squared residual, in noise floors, at the joint where it takes most.

    And the part that it leaves beyond noise: there, and at the joint where most is left.
    """

    size: float
    left: float
    anywhere: float


def _taken(step: Step) -> _Taken:
    shown, k = (step.ranking, step.ranking.best) if step.worth is None else (step.worth, 1)
    joint = int(np.argmax(shown.power[0] - shown.power[k]))
    before, after = float(shown.power[0, joint]), shown.power[k]
    left = np.maximum(after - 1.0, 0.0) / max(before - 1.0, 1e-9)
    return _Taken(before - float(after[joint]), float(left[joint]), float(left.max()))
