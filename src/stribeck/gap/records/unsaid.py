"""What an arm file says nothing of: friction or rotor inertia of zero, and how well its effects are known.

A tolerance is a part of a value, and a part of zero is zero. Files made from drawings often have no friction and no
rotor; held there, what is missing would pass for effects. Such values get a tolerance of their own.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from stribeck.arm import Arm, Joint
from stribeck.gap.result import Tuned
from stribeck.model.scale import Scale

FRICTION = 0.3  # of the rms torque: what friction may be where none is said
NEXT_TO_NOTHING = 1e-6  # of that: what a fit left at its bound
FAR = 0.5  # of an effect's value in the arm file, by which it may be off without a word
KEYS = ("C0", "C2", "rotor_inertia")


def with_unsaid(arm: Arm, scales: Sequence[Scale]) -> Arm:
    """Return the arm with a tolerance (one standard deviation, absolute) for each such value that has none."""
    joints = (
        replace(joint, tolerance={**_missing(arm, joint, scale), **joint.tolerance})
        for joint, scale in zip(arm.joints, scales, strict=True)
    )
    return replace(arm, joints=tuple(joints))


def _missing(arm: Arm, joint: Joint, scale: Scale) -> dict[str, float]:
    torque = FRICTION * scale.torque
    spread = {"C0": torque, "C2": torque / scale.speed, "rotor_inertia": arm.tolerance.inertial * scale.inertia}
    said = {
        "C0": max(joint.friction.C0, joint.backward.C0),
        "C2": max(joint.friction.C2, joint.backward.C2),
        "rotor_inertia": joint.rotor_inertia,
    }
    return {key: spread[key] for key in KEYS if said[key] <= NEXT_TO_NOTHING * spread[key]}


def told_of(tuned: Sequence[Tuned]) -> list[str]:
    """Return a warning for each value that has no tolerance in the arm file, and is surely another in the recordings.

    One that the file has as zero, or one of its effects' that is off by far.
    """
    return [
        f"{value.key}: {value.nominal:.3g} in the arm file, {value.tuned.value:.3g} {value.unit} by the recordings; "
        "re-tuning took it in"
        for value in tuned
        if value.identified and (_off(value) if math.isinf(value.tolerance) else _from_nothing(value))
    ]


def _from_nothing(value: Tuned) -> bool:
    told = value.key.rpartition(".")[2] in KEYS and value.nominal <= NEXT_TO_NOTHING * value.tolerance
    return told and value.tuned.low > 0.0


def _off(value: Tuned) -> bool:
    apart = abs(value.tuned.value - value.nominal) > FAR * abs(value.nominal)
    return apart and not value.tuned.low <= value.nominal <= value.tuned.high
