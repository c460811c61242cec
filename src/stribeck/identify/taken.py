"""The arm that an identification ends in: inertial values of the whole runs, friction of each direction's source."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from stribeck.arm import Arm, Friction, Joint
from stribeck.identify.findings import JointFriction
from stribeck.identify.run_fit import RunFit


def taken_arm(arm: Arm, joints: Sequence[JointFriction], whole: RunFit) -> Arm:
    """Return the fitted arm.

    Parameters
    ----------
    arm : Arm
        The nominal one, whose friction stays where each direction's source says so.
    joints : sequence of JointFriction
        One a joint of the arm.
    whole : RunFit
        Used where it succeeded.
    """
    body = whole.arm if whole.fit.ok else arm
    fitted = [_with(own, nominal, one) for own, nominal, one in zip(body.joints, arm.joints, joints, strict=True)]
    stated = (replace(joint, tolerance=nominal.tolerance) for joint, nominal in zip(fitted, arm.joints, strict=True))
    return replace(body, joints=tuple(stated), tolerance=arm.tolerance)


def _with(joint: Joint, nominal: Joint, found: JointFriction) -> Joint:
    """Return a joint of the fitted body with the friction of each direction's source.

    A direction that no run shows keeps its constants where the arm file states its own, and else has the other's.
    """
    if found.common is not None and found.common.ok and not found.asymmetric:
        friction = Friction(*found.common.constants.tolist())
        return replace(joint, friction=friction, backward=friction)
    own: dict[str, Friction] = {}
    for way, one in found.directions.items():
        if one.source in ("curve", "runs"):
            constants = one.curve.constants if one.source == "curve" else one.runs[0]
            own[way] = Friction(*constants.tolist())
    if not own:
        return replace(joint, friction=nominal.friction, backward=nominal.backward)
    if nominal.backward != nominal.friction:
        stated = {"forward": nominal.friction, "backward": nominal.backward}
        own |= {way: friction for way, friction in stated.items() if way not in found.directions}
    forward = own.get("forward") or own["backward"]
    return replace(joint, friction=forward, backward=own.get("backward", forward))
