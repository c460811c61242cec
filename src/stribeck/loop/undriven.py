"""An arm left to itself: without what time alone does to it."""

from __future__ import annotations

from dataclasses import replace

from stribeck.arm import Arm
from stribeck.effects.registry import effect_named


def undriven(arm: Arm) -> tuple[Arm, list[str]]:
    """Return an arm without the effects that drive it in time, and a warning for each of those.

    A limit cycle is what a loop does of itself; a corrected model may hold a disturbance all the same.
    """
    stays = [not effect_named(entry.effect, entry.law).waves for entry in arm.effects]
    warnings = [
        f"{', '.join(entry.joints)}: {entry.effect} drives the arm in time and is left out here; "
        "simulate shows what it does"
        for entry, stay in zip(arm.effects, stays, strict=True)
        if not stay
    ]
    return replace(arm, effects=tuple(e for e, stay in zip(arm.effects, stays, strict=True) if stay)), warnings
