"""Which effects may be added to a model, and which laws of a family are worth a full fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stribeck.arm import Arm
from stribeck.effects.registry import laws
from stribeck.model.effect import Effect, FrictionEffect, TransmissionEffect
from stribeck.model.layout import Placed

MOST = 0.5  # of the base's cost at a joint, that a law takes for others of its family to be fitted beside it
CLOSE = 0.9  # of what it takes, that these take


@dataclass(frozen=True)
class Trial:
    """A candidate effect at a joint with starting values, and the cost that its linear model promises."""

    effect: Effect
    joint: int
    start: dict[str, float]
    promise: float = 0.0

    @property
    def key(self) -> tuple[str, int]:
        """Effect name and joint."""
        return self.effect.name, self.joint

    @property
    def law_key(self) -> tuple[str, str, int]:
        """Effect name, law and joint."""
        return self.effect.name, self.effect.law, self.joint


def candidates(arm: Arm, placed: Sequence[Placed], leave_out: Sequence[str] = ()) -> list[tuple[Effect, int]]:
    """Return the effects (every law of each) and joints that can be added to those already placed."""
    taken = {(place.effect.name, place.joint) for place in placed}
    out = []
    for effect in (effect for effect in laws().values() if not effect.direct):
        for joint in effect.sites(arm.n):
            fits = effect.applies(arm, joint) and not _clashes(effect, joint, placed)
            if effect.name not in leave_out and fits and (effect.name, joint) not in taken:
                out.append((effect, joint))
    return out


def _clashes(effect: Effect, joint: int, placed: Sequence[Placed]) -> bool:
    """Return whether another effect already has the place: one compliance and one bristle a joint."""
    here = [place.effect for place in placed if place.joint == joint]
    if isinstance(effect, TransmissionEffect):
        return any(isinstance(other, TransmissionEffect) for other in here)
    if isinstance(effect, FrictionEffect) and effect.bristle:
        return any(isinstance(other, FrictionEffect) and other.bristle for other in here)
    return False


def best_laws(tried: Sequence[Trial]) -> list[Trial]:
    """Return the trials with, of each family at each joint, the law that promises most; ties go to the first."""
    best: dict[tuple[str, int], Trial] = {}
    for trial in tried:
        if trial.key not in best or trial.promise > best[trial.key].promise:
            best[trial.key] = trial
    return list(best.values())


def close_laws(tried: Sequence[Trial], kept: Sequence[Trial], cost: np.ndarray) -> list[Trial]:
    """Return other laws of the kept trials' families that take about as much of a gap which they take most of.

    Against the whole of a gap the laws of one family hardly differ; what they leave of it does, once they are fitted.

    Parameters
    ----------
    tried, kept : sequence of Trial
        All, and those that are fitted.
    cost : array (n,)
        Of the base at each joint, by the weights of the trials.
    """
    chosen = {trial.key: trial for trial in kept if trial.promise > MOST * cost[trial.joint]}
    rivals = (trial for trial in tried if trial.key in chosen and trial.effect.law != chosen[trial.key].effect.law)
    return [trial for trial in rivals if trial.promise > CLOSE * chosen[trial.key].promise]
