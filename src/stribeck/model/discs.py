"""Periodic errors of an encoder: where a law of them may start, and which fitted values can be meant."""

from __future__ import annotations

import math

import numpy as np

from stribeck.model.scale import HALF, Scale
from stribeck.model.waves import Trace, Wave, strongest_waves

TURNS = (1.0, 2.0)  # cycles per turn of the joint: off centre, and an oval disc
GEARED = (2.5, 60.0)  # cycles per turn, where the encoder turns faster than the joint
PERIOD = 1.5 * math.pi  # of an error's phase, that must be recorded
MOST_LOBES = 6.5  # of which a HALF of a period will do where they are a whole number: a disc that its screws bend
SLOPE = 0.5  # that the error may have
STEEPEST = 0.95  # slope of an error from which positions are as good as recorded twice
SMALL = 0.005  # rad, of a start
LINES = 2e-4  # rad, by which any encoder's reading waves: 40 seconds of arc, of its lines and what is read between them
SCREWS = 1e-5  # m, the same on an axis in m: of a scale or a screw
MOST = 0.15  # rad; nine degrees are more than a disc can run off centre: it is inertia and gravity that are meant


def waves_of_discs(scale: Scale, trace: Trace, count: int = 3) -> list[Wave]:
    """Return waves of the position (rad) to start from: those of a joint's own disc, then those of a residual.

    A wave of the position has a second derivative that goes with the square of the velocity.
    """
    lowest = PERIOD / scale.travel
    rates = scale.rates(1.0) if scale.prismatic else (max(GEARED[0], lowest), max(GEARED[1], 2.0 * lowest))
    waves = strongest_waves(trace.position, trace.velocity**2, trace, rates, count)
    return [*(() if scale.prismatic else discs()), *(_of_position(wave, scale) for wave in waves)]


def discs() -> list[Wave]:
    """Return waves of the position of a disc at the joint itself."""
    return [Wave(rate, SMALL, SMALL) for rate in TURNS]


def is_of_a_disc(size: float, rate: float, scale: Scale) -> bool:
    """Return whether an encoder can be off by so much, rad, at so many cycles per turn, and has shown it."""
    turns = not scale.prismatic and rate < TURNS[-1] + 0.2
    bent = rate < MOST_LOBES and scale.is_whole(rate) and rate * scale.travel > HALF * 2.0 * math.pi
    # much less than a period of another wave is any curve over position
    seen = turns or bent or rate * scale.travel > 0.99 * PERIOD
    return size < MOST and size * rate < SLOPE and seen


def as_any_reads(size: float, scale: Scale) -> bool:
    """Return whether waves of that amplitude, rad, are no more than any encoder has."""
    return size < (SCREWS if scale.prismatic else LINES)


def _of_position(wave: Wave, scale: Scale) -> Wave:
    """Return a wave of the position whose inertial torque is this one over the squared velocity, within bounds."""
    per = 1.0 / (scale.inertia * wave.rate**2)
    most = 0.3 * SLOPE / wave.rate
    sine, cosine = (float(np.clip(part * per, -most, most)) for part in (wave.sine, wave.cosine))
    return Wave(wave.rate, sine, cosine)
