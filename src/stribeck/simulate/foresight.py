"""An arm whose records are not early: no controller sees ahead."""

from __future__ import annotations

from dataclasses import replace

from stribeck.arm import Arm
from stribeck.effects.placing import entries_of, placed_effects
from stribeck.model.layout import Placed
from stribeck.model.scale import PROMPT


def without_foresight(arm: Arm) -> tuple[Arm, list[str]]:
    """Return an arm without what makes its records earlier by as little as any may be, and a warning of each.

    Re-tuning takes such lateness in, of either sign. What is earlier than that stays, for a loop to refuse.
    """
    placed = placed_effects(arm)
    early = [place for place in placed if _early(place)]
    if not early:
        return arm, []
    stays = tuple(place for place in placed if place not in early)
    said = [
        f"{arm.names[place.joint]}: a record that is {-1e3 * place.values['time']:.2g} ms early is left out here; "
        "no controller sees ahead"
        for place in early
    ]
    return replace(arm, effects=entries_of(arm, stays)), said


def _early(place: Placed) -> bool:
    return bool(place.effect.delays) and -PROMPT < place.values.get("time", 0.0) < 0.0
