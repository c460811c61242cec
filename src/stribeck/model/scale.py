"""What is usual of a joint: its magnitudes in the data at hand, and what any arm has some of."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca
import numpy as np

PROMPT = 1.6e-3
"""Lateness that any drive or record has, s: current loops of 100 Hz and more, a sample of a fast digital loop."""

GIVES = 1e-5
"""Way by which any contact gives before it slides, m: rolling elements and teeth do so by micrometres, up to ten."""

ARM_OF_CONTACT = 0.05
"""Radius at which the contacts of a joint that turns lie, m: of its bearings and gears."""

RENEWS = 0.005
"""Slide that renews any contact, m: what takes longer is the grease's structure, not the contact's age."""

RISES = 2.0
"""Part of its friction, or torque where that is more, by which a contact's break-away torque may rise in a second."""

STRAY = 0.015
"""Part of its torque by which any drive or gear strays: offsets, slots, ripples, sides that are not quite alike."""

PLAIN = 3.0
"""Noise floors, root mean square, from which on the waves of a drive are plain to see, and no habit of any."""

UNEVEN = 0.04
"""Part of its friction by which any joint's varies along its way: of meshing gears it is up to 0.25 (Garcia, 2002)."""

LIGHTEST = 0.01
"""Least part of a joint's inertia that is taken to lie beyond its transmission."""

MOST_A_TURN = 240.0
"""Cycles a turn that are looked for: magnets on slots, and the two a turn of a wave generator behind 100:1."""

MOST_PERIODS = 60.0
"""Periods over the travel that are looked for on an axis in m: a screw or a magnet track may have as many."""

LEAST_OF_PERIOD = 1.0
"""Part of a period that must be covered: less is any curve over position, a stiffening spring, an offset and cables."""

BENDS = 3.0
"""Periods covered, below which a wave bends like a spring: of a line, one of three takes less than a tenth."""

WHOLE, HALF, LEAST_WHOLE = 0.05, 0.5, 2.5
"""Of a whole number a turn, to WHOLE, as magnets, slots and screws come, a HALF will do; fewer may be gravity's."""

LEAST_DRIVE = 0.4
"""Part of the torque that a motion needs (root mean square): a drive with a lower limit would hardly drive."""


PLACES = 2001
"""Positions at which a curve is looked at along the way that a joint goes."""

OVERTONES = 5
"""Of a motion that swings, which friction and gravity make strong; those of friction fall as 1 / m."""


@dataclass(frozen=True)
class Scale:
    """Typical magnitudes of one joint in the data at hand, from which an effect takes its starting values.

    Attributes
    ----------
    torque, needed, friction : float
        Root mean square command, and torque that the nominal arm needs for the motion, and Coulomb friction, N m.
    speed : float
        Root mean square velocity, rad/s.
    travel, covered, middle : float
        Range of position in the run that goes furthest, and in all together, and its median, rad.
    inertia, rotor : float
        Inertia that the joint moves, others held, and its rotor's part of that, kg m^2.
    sample_time : float
        Of the recordings, s.
    length : float
        Of the joint's link, m.
    prismatic : bool
        Whether the joint is an axis in m: no turn says then how often what is periodic repeats.
    distance : float
        That the joint goes to and fro in all recordings together, rad.
    driven : bool
        Whether the joint has a drive that does anything; else the others' motion, or its weight, swings it, and
        ``torque`` is what that needs.
    rhythm : (float, float)
        Frequency at which the joint swings in all recordings, and how far from it others cannot be told, Hz; zeros
        where it does more than swing.
    noise : float
        Noise floor of its torque, N m; infinite until it is known.
    gravity : (float, float)
        The nominal arm's, in its plane, m/s^2.
    """

    torque: float
    friction: float
    speed: float
    travel: float
    inertia: float
    sample_time: float
    length: float = 1.0
    middle: float = 0.0
    prismatic: bool = False
    distance: float = math.inf
    rotor: float = 0.0
    covered: float = 0.0
    needed: float = math.inf
    driven: bool = True
    rhythm: tuple[float, float] = (0.0, 0.0)
    noise: float = math.inf
    gravity: tuple[float, float] = (0.0, 0.0)

    def may_limit(self, torque: float) -> bool:
        """Return whether a drive that gives no more than a torque, N m, drives the motion.

        A controller whose drive is at its limit asks for ever more: its command alone would be no measure.
        """
        return torque > LEAST_DRIVE * min(self.torque, self.needed)

    def keeps_time(self, frequency: float, waves: int = 1) -> bool:
        """Return whether a torque of so many harmonics of a frequency, Hz, may be part of the joint's own swinging.

        Whatever goes with the motion repeats as it does, with its overtones, of which OVERTONES may be strong.
        """
        own, apart = self.rhythm
        return own > 0.0 and any(
            abs(k * frequency - m * own) < apart for k in range(1, waves + 1) for m in range(1, OVERTONES + 1)
        )

    def rates(self, most: float = MOST_A_TURN) -> tuple[float, float]:
        """Return the range of cycles per radian of phase, 1/rad, in which a periodic law may start.

        From one to ``most`` a turn; on an axis in m from half a period over the travel to MOST_PERIODS of them.
        """
        return (math.pi / self.travel, 2.0 * math.pi * MOST_PERIODS / self.travel) if self.prismatic else (1.0, most)

    def furthest(self, position: float) -> float:
        """Return how far the joint goes from a position, rad, in a run about its median."""
        return abs(self.middle - position) + 0.5 * self.travel

    def varies(self, curve: Callable[[ca.DM], ca.DM]) -> float:
        """Return by which part of its mean a curve over position varies along the way that the joint goes.

        As a wave does that has this amplitude: slow ones may cancel each other there, or be little but a mean.
        """
        half = 0.5 * max(self.travel, self.covered)
        values = curve(ca.DM(np.linspace(self.middle - half, self.middle + half, PLACES))).full()
        return math.sqrt(2.0) * float(np.std(values)) / max(abs(float(np.mean(values))), np.finfo(float).tiny)

    @property
    def link(self) -> float:
        """Inertia that is moved through the transmission, kg m^2: all but the rotor's, which may be most of it."""
        return max(self.inertia - self.rotor, LIGHTEST * self.inertia)

    def shows(self, harmonic: float) -> bool:
        """Return whether enough of a period (``harmonic`` a radian) is covered to be more than any curve."""
        enough = HALF if harmonic > LEAST_WHOLE and self.is_whole(harmonic) else LEAST_OF_PERIOD
        return harmonic * max(self.travel, self.covered) > enough * 2.0 * math.pi

    def bends(self, harmonic: float) -> bool:
        """Return whether so few periods (``harmonic`` a radian) are covered that a wave may pass for a smooth curve."""
        return harmonic * max(self.travel, self.covered) < BENDS * 2.0 * math.pi

    def is_whole(self, harmonic: float) -> bool:
        """Return whether so many cycles a turn are a whole number of them."""
        return not self.prismatic and abs(harmonic - round(harmonic)) < WHOLE

    @property
    def stray(self) -> float:
        """Torque by which any drive or gear strays, N m."""
        return STRAY * self.torque

    def ripples(self, amplitude: float) -> bool:
        """Return whether the drive's torque waves by no more than any one's, N m: of its torque, and of the noise."""
        return amplitude < min(self.stray, PLAIN * math.sqrt(2.0) * self.noise)

    @property
    def gives(self) -> float:
        """Way by which any contact gives before it slides, rad: GIVES, for a joint that turns at ARM_OF_CONTACT."""
        return GIVES if self.prismatic else GIVES / ARM_OF_CONTACT

    @property
    def renews(self) -> float:
        """Slide that renews any contact, rad: RENEWS, for a joint that turns at ARM_OF_CONTACT."""
        return RENEWS if self.prismatic else RENEWS / ARM_OF_CONTACT

    @property
    def rises(self) -> float:
        """What a contact's break-away torque may rise by in a second of rest, N m.

        After a long rest it may be more than recordings with short ones tell.
        """
        return RISES * max(self.friction, self.torque)
