"""Where a model is linearised: a pose, velocities, and which joints slide, stick or have their friction left out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from stribeck.arm import Arm
from stribeck.errors import InputError
from stribeck.simulate.loop import JointLoop, Loop

Contact = Literal["slides", "sticks", "free", "clamped"]


@dataclass(frozen=True)
class OperatingPoint:
    """A steady motion, or rest, about which a model is linear.

    Attributes
    ----------
    position : tuple of n floats
        Joint positions, rad (m for a prismatic axis).
    velocity : tuple of n floats
        Joint velocities, rad/s; zero at a joint that does not slide.
    contact : tuple of n str
        ``slides``: friction's slope at that velocity; ``sticks``: a bristle's stiffness where the model has one, else
        no motion at all; ``free``: friction left out, which is how a gain is chosen that must hold wherever friction
        fails to help; ``clamped``: held still.
    """

    position: tuple[float, ...]
    velocity: tuple[float, ...]
    contact: tuple[Contact, ...]

    def __post_init__(self) -> None:
        if not len(self.position) == len(self.velocity) == len(self.contact):
            found = f"{len(self.position)}, {len(self.velocity)} and {len(self.contact)}"
            raise InputError("position, velocity and contact must be as many", found, "give one of each a joint")
        for speed, contact in zip(self.velocity, self.contact, strict=True):
            if contact in ("sticks", "clamped") and speed != 0.0:
                raise InputError(f"a joint that is {contact} cannot move", f"{speed:g} rad/s", "give velocity 0")
            if contact == "slides" and speed == 0.0:
                raise InputError("a joint that slides must move", "0 rad/s", "give a velocity, or let it stick")


def free(arm: Arm, loop: Loop) -> OperatingPoint:
    """Return the pose in which a loop works, friction of the controlled joints left out, the others clamped."""
    return _all(arm, loop, "free", 0.0)


def stuck(arm: Arm, loop: Loop) -> OperatingPoint:
    """Return the pose in which a loop works, at rest, every controlled joint stuck."""
    return _all(arm, loop, "sticks", 0.0)


def sliding(arm: Arm, loop: Loop, velocity: float) -> OperatingPoint:
    """Return the pose in which a loop works, with every controlled joint sliding at one velocity, rad/s."""
    return _all(arm, loop, "slides", velocity)


def _all(arm: Arm, loop: Loop, contact: Contact, velocity: float) -> OperatingPoint:
    controlled = [entry.joint for entry in loop.joints]
    return OperatingPoint(
        tuple(pose(arm, loop)),
        tuple(velocity if name in controlled else 0.0 for name in arm.names),
        tuple(contact if name in controlled else "clamped" for name in arm.names),
    )


def pose(arm: Arm, loop: Loop) -> list[float]:
    """Return the positions at which a loop is to work.

    References that end count where they end within the loop's duration, a ramp where it begins, a sine at its middle.
    Joints without a controller stand where they are clamped, at 0 where the loop does not say.

    Parameters
    ----------
    arm : Arm
        Of n joints.
    loop : Loop

    Returns
    -------
    list of n floats
        One for each joint of the arm, in its order: rad, m for a prismatic axis.
    """
    ends = {entry.joint: _end(entry, loop.duration) for entry in loop.joints}
    return [ends.get(name, loop.clamp.get(name, 0.0)) for name in arm.names]


def _end(entry: JointLoop, duration: float) -> float:
    values = entry.reference.within(duration).values if entry.reference.kind in ("steps", "file") else ()
    return values[-1] if values else entry.start
