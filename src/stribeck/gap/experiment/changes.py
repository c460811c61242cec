"""Physical changes of the arm or its stand that a second recording can be made with, as known stages of the path."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, final

from stribeck.arm import Arm
from stribeck.effects.rigid_body.payload import Payload
from stribeck.model.effect import ActuatorEffect, Along, RigidBodyEffect
from stribeck.model.layout import Placed
from stribeck.model.scale import Scale
from stribeck.model.values import STANDARD_GRAVITY, Body, Expression, Parameter, Parameters, Signals, States

PAYLOAD = 0.3  # of the last link's mass


class _Known:
    """A stage without parameters: what is changed is known."""

    parameters: ClassVar[tuple[Parameter, ...]] = ()
    equation: ClassVar[str] = ""
    symptom: ClassVar[str] = ""
    source: ClassVar[str] = ""

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        """Return nothing to start from."""
        return ({},)


@final
class Turned(_Known, RigidBodyEffect):
    """The base turned by half a turn in the arm's plane: gravity, a tilt included, points the other way."""

    name = "turned"
    channel = "rigid_body"

    def body(self, body: Body, joint: int, p: Parameters) -> Body:
        """Return the changed body."""
        return replace(body, gravity=(-body.gravity[0], -body.gravity[1]))


@final
class Raised(_Known, RigidBodyEffect):
    """A horizontal arm stood on its side."""

    name = "raised"
    channel = "rigid_body"

    def body(self, body: Body, joint: int, p: Parameters) -> Body:
        """Return the changed body."""
        return replace(body, gravity=(body.gravity[0] + STANDARD_GRAVITY, body.gravity[1]))


class Reversed(_Known, ActuatorEffect):
    """The sign of the command turned; with the leads turned as well, it turns the drive around."""

    name = "reversed"
    channel = "actuator"
    along = Along.COMMAND

    def torque(self, torque: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        """Return the torque with the other sign, N m."""
        return -torque

    def command_scale(self, position: Expression, p: Parameters) -> Expression:
        """Return the sign."""
        return -1.0


@final
class ReversedLeads(Reversed):
    """The sign of the motor's torque turned, but for what its iron adds without any current."""

    name = "reversed_leads"
    along = Along.SHAFT


@final
class Loaded(_Known, RigidBodyEffect):
    """A known mass (kg) at the tip."""

    name = "loaded"
    channel = "rigid_body"

    def __init__(self, mass: float) -> None:
        self.mass = mass

    def body(self, body: Body, joint: int, p: Parameters) -> Body:
        """Return the changed body."""
        return Payload().body(body, joint, {"mass": self.mass})


@dataclass(frozen=True)
class Change:
    """A known change: stages that come ``before`` and ``after`` those of a model, and in words what is to be done.

    And by which arm file the recording is to be diagnosed then, and how the right cause shows.
    """

    words: str
    before: tuple[Placed, ...] = ()
    after: tuple[Placed, ...] = ()
    known_by: str = "an arm file that says so; the right cause keeps its parameters"

    def around(self, placed: Sequence[Placed]) -> tuple[Placed, ...]:
        """Return a model's placed effects with the change around them."""
        return (*self.before, *placed, *self.after)


def changes(arm: Arm, joints: Sequence[int], *, tilted: bool = False) -> tuple[Change, ...]:
    """Return the changes that can be made to an arm, those of a drive at each of ``joints`` (indices).

    One that is horizontal by its file may be ``tilted``. A second set of gains is not among the changes: along a given
    motion it changes the torque of no candidate.
    """
    last = arm.n - 1
    out = []
    for j in dict.fromkeys(joints):
        what = f"reverse the polarity of the drive of joint {arm.names[j]} (motor leads, and the command's sign)"
        shows = "the same arm file; what sits in the drive then changes its sign, what sits elsewhere keeps it"
        out.append(Change(what, (Placed(Reversed(), j),), (Placed(ReversedLeads(), j),), shows))
    if arm.joints[0].kind == "revolute":
        mass = float(f"{PAYLOAD * arm.joints[last].mass:.2g}")
        out.append(Change(f"fix a known payload of {mass:g} kg at the tip", (), (Placed(Loaded(mass), last),)))
    if any(arm.gravity):
        out.append(Change("turn the base by half a turn, so that gravity pulls the other way", (), (_at(Turned()),)))
    elif tilted:
        what = "turn the base by half a turn in the arm's plane, so that a tilt pulls the other way"
        shows = "the same arm file; a tilt then changes its sign, what sits elsewhere keeps it"
        out.append(Change(what, (), (_at(Turned()),), shows))
    if not any(arm.gravity) and arm.joints[0].kind == "revolute":
        out.append(Change("stand the arm on its side, so that gravity pulls along its plane", (), (_at(Raised()),)))
    return tuple(out)


def _at(effect: RigidBodyEffect) -> Placed:
    return Placed(effect, 0)
