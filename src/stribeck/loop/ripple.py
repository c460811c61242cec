"""Ripples that an arm forces on a loop: a ramp leads its joint past waves over position, at a period that they set."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from stribeck.arm import Arm
from stribeck.effects.placing import placed_effects
from stribeck.model.values import OVER_POSITION
from stribeck.simulate import Loop

GRAVITY = "gravity"
ALIKE = 0.01  # of the period, by which that of a ripple may differ from that of what forces it


@dataclass(frozen=True)
class Passage:
    """What a ramp passes again and again.

    Attributes
    ----------
    cause : str
        Name of the effect, or ``gravity``.
    joint : str
        Whose ramp it is.
    time : float
        From one wave to the next, or for a whole turn, s.
    """

    cause: str
    joint: str
    time: float


def passages(arm: Arm, loop: Loop) -> tuple[Passage, ...]:
    """Return what the ramps of a loop lead its joints past: waves of effects over position, and turns under gravity."""
    speeds = {
        entry.joint: abs(entry.reference.velocity)
        for entry in loop.joints
        if entry.reference.kind == "ramp" and entry.reference.velocity != 0.0
    }
    found = []
    for place in placed_effects(arm):
        name = arm.names[place.joint]
        for parameter in place.effect.parameters:
            rate = place.values.get(parameter.name, parameter.null)
            if name in speeds and parameter.unit in OVER_POSITION and rate > 0.0:
                found.append(Passage(place.effect.name, name, 2.0 * math.pi / (rate * speeds[name])))
    turns = [joint.name for joint in arm.joints if joint.kind == "revolute" and joint.name in speeds]
    if any(arm.gravity):
        found += [Passage(GRAVITY, name, 2.0 * math.pi / speeds[name]) for name in turns]
    return tuple(found)


def forced_by(verdict: str, period: float | None, passed: Iterable[Passage]) -> Passage | None:
    """Return what forces a motion that never sticks and has the period (s) of a passage; None of any other motion.

    One that sticks lets go by itself, whatever it is led past.
    """
    if verdict != "sliding_cycle" or not period:
        return None
    return next((each for each in passed if abs(period / each.time - 1.0) <= ALIKE), None)
