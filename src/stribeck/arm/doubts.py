"""Values of an arm file that no arm on a bench or in a factory has: most are in another unit."""

from __future__ import annotations

import math

from stribeck.arm.values import Arm, Joint

LONGEST = 10.0  # m, of a link, and of the way to its centre of mass
HEAVIEST = 1000.0  # kg
BEYOND = 3.0  # link lengths, or SHORT where that is more: a payload's centre of mass may lie beyond a link, not so far
SHORT = 1.0  # m
COARSEST = 0.1  # rad; 63 counts a turn
SLOWEST = 0.2  # s, of a controller


def doubtful_values(arm: Arm) -> list[str]:
    """Return a warning for each value that is hardly meant, with what to check.

    Parameters
    ----------
    arm : Arm
        With values that its file may have.
    """
    said = [text for joint in arm.joints for text in _of_joint(joint)]
    if arm.sample_time is not None and arm.sample_time > SLOWEST:
        said.append(f"the arm file's sample_time is {arm.sample_time:g} s: are these milliseconds?")
    return said


def _of_joint(joint: Joint) -> list[str]:
    turns = joint.kind == "revolute"  # of a straight axis neither length nor com matters
    unit, angle = ("rad", "degrees") if turns else ("m", "mm")
    away = math.hypot(*joint.com)
    said = []
    if turns and joint.length > LONGEST:
        said.append(f"length is {joint.length:g} m: are these mm?")
    if turns and away > LONGEST:
        said.append(f"com lies {away:g} m from its axis: are these mm?")
    elif turns and 0.0 < BEYOND * joint.length < away and away > SHORT:
        said.append(f"com lies {away:g} m from its axis, on a link of {joint.length:g} m: check its decimal point")
    if joint.mass > HEAVIEST:
        said.append(f"mass is {joint.mass:g} kg: are these grams?")
    if joint.encoder_resolution is not None and joint.encoder_resolution > COARSEST:
        said.append(f"encoder_resolution is {joint.encoder_resolution:g} {unit}: are these {angle}?")
    return [f"{joint.name}: the arm file's {text}" for text in said]
