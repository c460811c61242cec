"""What an arm file says nothing of: friction or rotor inertia of zero.

A tolerance is a part of a value, and a part of zero is zero. Files made from drawings often have no friction and no
rotor; held there, what is missing would pass for effects. Such values get a tolerance of their own.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stribeck.arm import Arm, Joint, with_unit
from stribeck.gap.result import Tuned
from stribeck.model.scale import Scale

FRICTION = 0.3  # of the rms torque: what friction may be where none is said
NEXT_TO_NOTHING = 1e-6  # of that: what a fit left at its bound
KEYS = ("C0", "C2", "rotor_inertia")


def with_unsaid(arm: Arm, scales: Sequence[Scale], still: Sequence[bool] | np.ndarray) -> Arm:
    """Return the arm with a tolerance (one standard deviation, absolute) for each such value that has none.

    Not for the friction of joints that stand ``still`` (n,): at rest any constants will do.
    """
    joints = (
        replace(joint, tolerance={**_missing(arm, joint, scale, bool(rests)), **joint.tolerance})
        for joint, scale, rests in zip(arm.joints, scales, still, strict=True)
    )
    return replace(arm, joints=tuple(joints))


def _missing(arm: Arm, joint: Joint, scale: Scale, still: bool) -> dict[str, float]:
    torque = FRICTION * scale.torque
    spread = {"C0": torque, "C2": torque / scale.speed, "rotor_inertia": arm.tolerance.inertial * scale.inertia}
    said = {
        "C0": max(joint.friction.C0, joint.backward.C0),
        "C2": max(joint.friction.C2, joint.backward.C2),
        "rotor_inertia": joint.rotor_inertia,
    }
    keys = KEYS[-1:] if still else KEYS
    return {key: spread[key] for key in keys if said[key] <= NEXT_TO_NOTHING * spread[key]}


def told_of(tuned: Sequence[Tuned]) -> list[str]:
    """Return a warning for each value that the arm file has as zero, and the recordings surely have not.

    And for each value of its effects, which the file says no tolerance of, that has moved far.
    """
    return [
        f"{value.key}: {value.nominal:.3g} in the arm file, {with_unit(f'{value.tuned.value:.3g}', value.unit)} by the "
        "recordings; re-tuning took it in"
        for value in tuned
        if value.moved or _was_missing(value)
    ]


def _was_missing(value: Tuned) -> bool:
    known = value.key.rpartition(".")[2] in KEYS and value.identified and math.isfinite(value.tolerance)
    return known and value.nominal <= NEXT_TO_NOTHING * value.tolerance and value.tuned.low > 0.0
