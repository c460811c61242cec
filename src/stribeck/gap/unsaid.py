"""What an arm file says nothing of: friction or rotor inertia of zero.

A tolerance is a part of a value, and a part of zero is zero. Files made from drawings often have no friction and no
rotor; held there, what is missing would pass for effects. Such values get a tolerance of their own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from stribeck.arm import Arm, Joint
from stribeck.gap.result import Tuned
from stribeck.model.values import Scale

FRICTION = 0.3  # of the rms torque: what friction may be where none is said
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
        "C0": joint.friction.C0 or joint.backward.C0,
        "C2": joint.friction.C2 or joint.backward.C2,
        "rotor_inertia": joint.rotor_inertia,
    }
    return {key: spread[key] for key in KEYS if not said[key]}


def told_of(tuned: Sequence[Tuned]) -> list[str]:
    """Return a warning for each value that the arm file has as zero and the recordings surely have not."""
    return [
        f"{value.key}: 0 in the arm file, {value.tuned.value:.3g} {value.unit} by the recordings; re-tuning took it in"
        for value in tuned
        if value.nominal == 0.0 and value.key.rpartition(".")[2] in KEYS and value.identified and value.tuned.low > 0.0
    ]
