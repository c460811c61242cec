"""A fit as an arm: the values that the arm file of a fitted, re-tuned or corrected model carries."""

from __future__ import annotations

from dataclasses import replace

from stribeck.arm import Arm, Friction, Joint
from stribeck.identify.map_fit import Fit


def arm_with(arm: Arm, fit: Fit) -> Arm:
    """Return an arm with a fit's inertial values and friction constants; its effects stay."""
    values = {entry.key: float(fit.p[i]) for i, entry in enumerate(fit.entries)}
    return replace(arm, joints=tuple(_joint(joint, values) for joint in arm.joints))


def _joint(joint: Joint, values: dict[str, float]) -> Joint:
    def constants(side: str) -> Friction:
        return Friction(*[values[f"{joint.name}.{side}.{key}"] for key in ("C0", "C1", "C2", "alpha")])

    forward = constants("friction")
    two_sided = f"{joint.name}.backward.C0" in values
    return replace(
        joint,
        mass=values[f"{joint.name}.mass"],
        com=(values[f"{joint.name}.com_x"], values[f"{joint.name}.com_y"]),
        inertia=values[f"{joint.name}.inertia"],
        rotor_inertia=values[f"{joint.name}.rotor_inertia"],
        friction=forward,
        backward=constants("backward") if two_sided else forward,
    )
