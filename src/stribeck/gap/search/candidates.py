"""Which effects may be added to a model."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from stribeck.arm import Arm
from stribeck.effects.registry import laws
from stribeck.model.effect import Effect
from stribeck.model.layout import Placed, rival


@dataclass(frozen=True)
class Trial:
    """A candidate effect at a joint with starting values, and the cost that its linear model promises.

    One that an earlier search has ``fitted`` starts where that fit ended.
    """

    effect: Effect
    joint: int
    start: dict[str, float]
    promise: float = 0.0
    fitted: bool = False

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
            fits = effect.applies(arm, joint) and rival(effect, joint, placed) is None
            here = Placed(effect, joint).joints(arm.n)
            if effect.name not in leave_out and fits and not any((effect.name, j) in taken for j in here):
                out.append((effect, joint))
    return out
