"""Motion that something forces on a loop: a dither, or waves over position that a ramp leads its joint past."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stribeck.arm import Arm
from stribeck.effects.placing import placed_effects
from stribeck.loop.cycle import CYCLES, FORCED, RIPPLE
from stribeck.model.values import OVER_POSITION
from stribeck.simulate import Loop

GRAVITY, DITHER = "gravity", "dither"
ALIKE = 0.01  # of what forces a motion, by which the period of the motion may differ from its own
MOST = 10.0  # periods of a dither after which the motion that it forces may repeat; samples fall on them in turn


@dataclass(frozen=True)
class Passage:
    """What comes again and again: a dither's period, or what a ramp passes.

    Attributes
    ----------
    cause : str
        ``dither``, name of the effect, or ``gravity``.
    joint : str
        Whose dither or ramp it is.
    time : float
        From one period or wave to the next, or for a whole turn, s.
    """

    cause: str
    joint: str
    time: float

    @property
    def word(self) -> str:
        """What it forces, in words."""
        return FORCED if self.cause == DITHER else RIPPLE

    def explains(self, verdict: str) -> bool:
        """Tell whether it can force a motion of this kind.

        Under waves one that sticks lets go by itself, whatever it is led past; a dither pulls it off.
        """
        return verdict in CYCLES if self.cause == DITHER else verdict == "sliding_cycle"

    def keeps(self, period: ArrayLike) -> NDArray[np.bool_]:
        """Tell which periods (...), s, are its own, or a few of a dither's."""
        ratio = np.asarray(period, dtype=np.float64) / self.time
        count = np.clip(np.round(ratio), 1.0, MOST) if self.cause == DITHER else 1.0
        alike: NDArray[np.bool_] = np.abs(ratio - count) <= ALIKE
        return alike


def passages(arm: Arm, loop: Loop) -> tuple[Passage, ...]:
    """Return what may force a loop's motion.

    The dithers of its joints; and what its ramps lead them past: waves of effects over position, and turns under
    gravity.
    """
    speeds = {
        entry.joint: abs(entry.reference.velocity)
        for entry in loop.joints
        if entry.reference.kind == "ramp" and entry.reference.velocity != 0.0
    }
    laws = [(entry.joint, entry.compensation) for entry in loop.joints]
    found = [
        Passage(DITHER, name, 1.0 / law.frequency)
        for name, law in laws
        if law.kind == "dither" and law.amplitude > 0.0 and law.frequency > 0.0
    ]
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
    """Return what forces a motion of this verdict and period (s); None of a cycle of the loop's own, or of none."""
    if not period:
        return None
    return next((each for each in passed if each.explains(verdict) and bool(each.keeps(period))), None)
