"""An arm left to itself: without what time alone does to it."""

from __future__ import annotations

from dataclasses import replace

from stribeck.arm import Arm
from stribeck.effects.placing import placed_effects
from stribeck.effects.registry import effect_named


def undriven(arm: Arm) -> tuple[Arm, tuple[str, ...]]:
    """Return an arm without the effects that drive it in time, and a note for each joint that one would drive.

    A limit cycle is what a loop does of itself, and no file says at what phase a recording met a disturbance.
    """
    notes = [
        f"{arm.names[place.joint]}: {place.effect.name} drives the arm in time, at its own phase: left out here"
        for place in placed_effects(arm)
        if place.effect.waves
    ]
    stays = tuple(entry for entry in arm.effects if not effect_named(entry.effect, entry.law).waves)
    return replace(arm, effects=stays), tuple(notes)
