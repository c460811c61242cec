"""Which effects may be added to a model."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from stribeck.arm import Arm
from stribeck.effects.registry import laws
from stribeck.model.effect import Effect, FrictionEffect, StandEffect, TransmissionEffect
from stribeck.model.layout import Placed


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

    @property
    def idle(self) -> dict[str, float]:
        """Values at which the effect is none, as far as they are numbers that a fit can leave; the others start."""
        none = {p.name: p.null for p in self.effect.parameters if not p.log and math.isfinite(p.null)}
        return {**self.start, **none}


def candidates(arm: Arm, placed: Sequence[Placed], leave_out: Sequence[str] = ()) -> list[tuple[Effect, int]]:
    """Return the effects (every law of each) and joints that can be added to those already placed."""
    taken = {(place.effect.name, joint) for place in placed for joint in place.joints(arm.n)}
    out = []
    for effect in (effect for effect in laws().values() if not effect.direct):
        for joint in effect.sites(arm.n):
            fits = effect.applies(arm, joint) and not clashes(effect, joint, placed)
            here = Placed(effect, joint).joints(arm.n)
            if effect.name not in leave_out and fits and not any((effect.name, j) in taken for j in here):
                out.append((effect, joint))
    return out


def clashes(effect: Effect, joint: int, placed: Sequence[Placed]) -> bool:
    """Return whether another effect already has the place: one compliance and one bristle a joint, one stand an arm."""
    if isinstance(effect, StandEffect):
        return any(isinstance(place.effect, StandEffect) for place in placed)
    here = [place.effect for place in placed if place.joint == joint]
    if isinstance(effect, TransmissionEffect):
        return any(isinstance(other, TransmissionEffect) for other in here)
    if isinstance(effect, FrictionEffect) and effect.bristle:
        return any(isinstance(other, FrictionEffect) and other.bristle for other in here)
    return False
