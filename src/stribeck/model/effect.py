"""What an effect is: a change to exactly one stage of the signal path.

One declaration serves every use of the model. The hooks take and return CasADi expressions, so the same law
is fitted along a recorded motion, simulated forward, linearised and exported. A hook that a class leaves out
passes its stage through unchanged.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from enum import IntEnum
from types import MappingProxyType
from typing import Any, ClassVar, Literal, TypeAlias

import casadi as ca

from stribeck.model.scale import Scale
from stribeck.model.values import Body, Expression, Observed, Parameter, Parameters, Record, Signals, States, Tip
from stribeck.model.waves import Trace

Shows: TypeAlias = Literal[
    "time", "frequency", "position", "velocity", "acceleration", "command", "command rate", "load", "load reversal",
    "travel", "start", "recorded position", "recorded velocity",
]  # fmt: skip
"""Across what a symptom shows. ``load`` is the torque handed to the link, ``load reversal`` the time since it changed
sign, ``travel`` the distance since the motion did, ``start`` the time since the joint began to move; the two records
are those of ``direct`` effects."""


class Effect(ABC):
    """Base of all effects; subclass one of the stage classes below, never this one."""

    name: ClassVar[str]
    """The family's name: effects of one name are laws of one phenomenon, and a joint has at most one of them."""
    law: ClassVar[str] = ""
    """Which law of the family this is; empty where the family has but one."""
    channel: ClassVar[str]
    parameters: ClassVar[tuple[Parameter, ...]]
    equation: ClassVar[str]
    symptom: ClassVar[str]
    shows: ClassVar[Shows] = "time"
    """Across what the residual is drawn for the symptom to be seen."""
    source: ClassVar[str]
    states: ClassVar[tuple[str, ...]] = ()
    state_units: ClassVar[Mapping[str, str]] = MappingProxyType({})
    """The states' units as in parameters; "1" where one is left out."""
    delays: ClassVar[str | None] = None
    """The signal that the parameter ``time`` delays: ``"command"``, the recorded ``"position"`` or None."""
    nonlinear: ClassVar[bool] = False
    """True where a trial's linear model says little of a full fit (a stiffness, a gap)."""
    elusive: ClassVar[bool] = False
    """True where a law about rest, slow motion or small torque also fits what noise and filters do there: it must be
    surer to be named."""
    zone: ClassVar[bool] = False
    """True where small torques, or motions, get lost: a linear model is of what passes beyond, torques as they came and
    ``touching`` faces."""
    waves: ClassVar[int] = 0
    """How many times its parameter ``frequency`` (Hz) the fastest wave in time of the law is; 0 where it has none."""
    rescales: ClassVar[bool] = False
    """True where wrong values of mass or torque mimic it: a candidate wherever re-tuning strains those values."""
    filters: ClassVar[bool] = False
    """True where the law is a linear filter of torque or motion (a lag, a delay, a resonance): random torque in a loop,
    which answers to it, looks a little as if there were one."""
    patternless: ClassVar[bool] = False
    """True where the phenomenon may also come without the law's pattern: random torque is then put down to it, too."""
    alone: ClassVar[str] = ""
    """What is no effect of the library and takes the same torque where the arm has one joint only."""
    kin: ClassVar[tuple[str, ...]] = ()
    """Phenomena, words shared by laws: a law may fill in what another one leaves of a phenomenon that both are of."""
    edged: ClassVar[bool] = False
    """True where the torque over position has an edge, which no wave bends like."""
    direct: ClassVar[bool] = False
    """True where the records themselves show the effect (``observed``), which leaves no trace in the torque."""
    whole_arm: ClassVar[bool] = False
    """True where the effect belongs to the arm and is declared once, at the joint named in ``sites``."""

    everywhere: ClassVar[bool] = False
    """True where a law that is declared at one joint holds at all of them alike."""

    @property
    def label(self) -> str:
        """The name, and the law where the family has several: ``presliding/lugre``."""
        return f"{self.name}/{self.law}" if self.law else self.name

    def sites(self, n: int) -> tuple[int, ...]:
        """Return the joints (indices) at which the effect can sit on an arm of ``n`` joints."""
        return tuple(range(n))

    def applies(self, arm: Any, joint: int) -> bool:
        """Return whether the effect is a candidate for this arm and joint at all."""
        return True

    def __eq__(self, other: object) -> bool:
        """Return whether it is the same law: one that came from another process is."""
        return type(self) is type(other) and vars(self) == vars(other)

    def __hash__(self) -> int:
        return hash(type(self))

    @abstractmethod
    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        """Return trial values from which a fit starts, clear of the null, most likely first."""

    def starts_from(self, scale: Scale, trace: Trace) -> tuple[dict[str, float], ...]:
        """Return trial values in sight of what the model so far leaves at the joint, as a frequency needs it."""
        return self.starts(scale)

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        """Return whether fitted values can be meant: not a corner where the law stands for another one, or for none."""
        return True

    def also(self, values: Mapping[str, float], scale: Scale) -> tuple[str, ...]:
        """Return the names of other effects that such fitted values may as well mean."""
        return ()

    def phenomena(self, values: Mapping[str, float], scale: Scale) -> tuple[str, ...]:
        """Return of which of its ``kin`` fitted values are."""
        return self.kin

    def ordinary(self, values: Mapping[str, float], scale: Scale) -> bool:
        """Return whether fitted values are what every arm has some of: fitted along with the others, never named."""
        return False

    def on_average(self, values: Mapping[str, float], starts: Sequence[Signals]) -> dict[str, float]:
        """Return values with which a simulation, that has no past, starts as recordings with some pasts do on average.

        ``starts`` hold the past of each recording at the joint, and no more.
        """
        return dict(values)

    def observed(self, record: Record) -> Observed | None:
        """Return what the records show of a ``direct`` effect; None where they show nothing of it."""
        return None

    def derivatives(self, s: Signals, x: States, p: Parameters) -> dict[str, Expression]:
        """Return the time derivative of each state."""
        return {}

    def initial(self, s: Signals, p: Parameters) -> dict[str, Expression]:
        """Return the states in which a recording starts."""
        return dict.fromkeys(self.states, 0.0)


class Along(IntEnum):
    """Where along a drive an actuator effect sits.

    The path has them in this order, whichever was found first: a lag does not smooth the ripple of the motor behind it.
    """

    COMMAND = 0
    """What is asked for."""
    AMPLIFIER = 1
    """How the amplifier switches."""
    LIMIT = 2
    """What the amplifier can give."""
    CURRENT = 3
    """The amplifier's control loop."""
    MOTOR = 4
    """The torque that becomes of the current."""
    SHAFT = 5
    """What is added to that torque."""
    IRON = 6
    """What the iron adds without any current."""


class ActuatorEffect(Effect):
    """A change between the command and the torque at the motor."""

    along: ClassVar[Along] = Along.MOTOR

    clips: ClassVar[bool] = False
    """True where part of the command may be lost: a gain over 1 does not make residuals smaller then, or a large one of
    the little that is left would make any of them small."""

    def torque(self, torque: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        """Return the torque after this stage from the one before it, N m."""
        return torque

    def command_scale(self, position: Expression, p: Parameters) -> Expression:
        """Return d(torque)/d(command) at a position: residuals are divided by it to stay in units of the command.

        Where another effect of the joint ``clips``, by no more than 1.
        """
        return 1.0


class TransmissionEffect(Effect):
    """A compliance between motor and link; the link then has a position and velocity of its own."""

    rough: ClassVar[float] = 0.0
    """Relative step over which a residual is smooth, where blows make derivatives at a point useless; else 0."""
    damper: ClassVar[str | None] = None
    """Parameter that damps those blows, if one does."""
    room: ClassVar[str | None] = None
    """Parameter that is the room between them, if one is."""

    @abstractmethod
    def transmitted(self, deflection: Expression, rate: Expression, p: Parameters) -> Expression:
        """Return the torque handed to the link from the deflection (motor minus link, rad) and its rate."""

    def touching(self, deflection: Expression, rate: Expression, p: Parameters) -> tuple[Expression, Expression]:
        """Return stiffness, N m/rad, and damping, N m s/rad, at a deflection (SX symbols); of faces, as if they met."""
        torque = self.transmitted(deflection, rate, p)
        return ca.jacobian(torque, deflection), ca.jacobian(torque, rate)

    def carrier(self, p: Parameters) -> Expression | None:
        """Return the inertia (kg m^2) that carries the motor and yields with it; None where the motor stands firm."""
        return None

    @abstractmethod
    def deflection(self, torque: Expression, p: Parameters) -> Expression:
        """Return the static deflection (rad) under a torque: where a recording starts."""


class Upon(IntEnum):
    """What a law of friction changes: the curve over velocity, it by place, it by load, or all that comes of these.

    The path has them in this order, whichever was found first: where friction wears in, that by load does as well.
    """

    CURVE = 0
    PLACE = 1
    LOAD = 2
    ALL = 3


class FrictionEffect(Effect):
    """A change of joint friction, tau_f = sign(v) G + B with G the sliding level and B the rest."""

    upon: ClassVar[Upon] = Upon.CURVE
    uses_load: ClassVar[bool] = False
    """True where the level goes with the torque that the link takes: it depends on the acceleration then."""
    uses_weight: ClassVar[bool] = False
    """True where it goes with the torque that gravity asks for, which the pose alone tells."""
    uses_torque: ClassVar[bool] = False
    """True where the level goes with the motor's torque, by less than all of it."""
    uses_friction: ClassVar[bool] = False
    """True where a state goes with the size of friction itself."""
    bristle: ClassVar[bool] = False
    """True where a state carries the friction instead of its sign: there is no stuck mode then."""
    abrupt: ClassVar[bool] = False
    """True where such a state bends into its limit so sharply that a solver which does not know of it may stop."""

    def constants(self, constants: Parameters, s: Signals, x: States, p: Parameters) -> Parameters:
        """Return Tustin's constants (``C0``, ``C1``, ``C2``, ``alpha``) from which the sliding level is taken."""
        return constants

    def speed(self, speed: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        """Return the speed (rad/s, at least 0) at which the sliding level is taken."""
        return speed

    def level(self, level: Expression, direction: float, s: Signals, x: States, p: Parameters) -> Expression:
        """Return the sliding level G (N m, at least 0) for motion in one direction.

        Parameters
        ----------
        level : expression
            The one before this effect, N m.
        direction : float
            1 or -1.
        s : Signals
            Of the joint.
        x, p : mapping of str to expression
            States and parameters of the effect.
        """
        return level

    def viscous(self, torque: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        """Return the part B (N m) that has no sign function."""
        return torque

    def bristle_torque(self, level: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        """Return the friction torque without B that replaces sign(v) G (only where ``bristle``)."""
        raise NotImplementedError

    def bristle_mean_torque(self, rate: Expression, x: States, p: Parameters) -> Expression | None:
        """Return the same at a sample, given the mean rate of all its states together about it; None: as at an instant.

        A bristle bends within an instant at a reversal; what damps it there is a pulse between two samples.

        Parameters
        ----------
        rate : expression
            By the recorded motion, from the sample before to the one after, unit of the states over s.
        x, p : mapping of str to expression
            States and parameters of the effect.
        """
        return None

    def bristle_holding(self, torque: Expression, level: Expression) -> dict[str, Expression]:
        """Return the states that hold a torque, of at most the level, when it was put on a bristle that held none."""
        return {name: share * torque for name, share in zip(self.states, self.bristle_shares(), strict=True)}

    def bristle_shares(self) -> tuple[float, ...]:
        """Return what part each state carries of a torque of which no more is known (only where ``bristle``)."""
        return (1.0 / len(self.states),) * len(self.states)

    def bristle_stiffness(self, p: Parameters) -> Expression:
        """Return the torque per way of a bristle that sticks, N m/rad (only where ``bristle``)."""
        return p["stiffness"]

    def bristle_derivatives(self, level: Expression, s: Signals, x: States, p: Parameters) -> dict[str, Expression]:
        """Return the derivatives of the bristle's states, given the level for the present direction."""
        raise NotImplementedError

    def bristle_moved(
        self, level: Expression, distance: Expression, x: States, p: Parameters
    ) -> dict[str, Expression] | None:
        """Return the bristle's states after a slide of ``distance`` (rad) one way; None where no closed form is known.

        Along a recorded motion it takes the place of a step by the derivatives.
        """
        return None


class RigidBodyEffect(Effect):
    """A change of the inertial parameters or of gravity."""

    def body(self, body: Body, joint: int, p: Parameters) -> Body:
        """Return the changed body."""
        return body


class StandEffect(Effect):
    """A stand that moves the first axis along a line; its states are how far it is from rest, and how fast it moves."""

    states = ("position", "velocity")
    state_units = MappingProxyType({"position": "m", "velocity": "m/s"})

    @abstractmethod
    def way(self, p: Parameters) -> tuple[Expression, Expression]:
        """Return the unit vector along which it slides, in the base frame."""

    def turn(self, p: Parameters) -> Expression:
        """Return by how much it turns with the first axis as it moves, rad/m."""
        return 0.0

    @abstractmethod
    def mass(self, p: Parameters) -> Expression:
        """Return the mass that slides with the first axis, the arm apart, kg."""

    @abstractmethod
    def force(self, x: States, p: Parameters) -> Expression:
        """Return the force along the way that the ground puts on it, N."""


class ExternalEffect(Effect):
    """A torque on the link, or a force on the arm's tip, from outside the model."""

    def torque(self, s: Signals, x: States, p: Parameters) -> Expression:
        """Return the torque that the drive must overcome, N m."""
        return 0.0

    def tip_force(self, tip: Tip, x: States, p: Parameters) -> tuple[Expression, Expression]:
        """Return the force (x, y), N in the base frame, that all drives together must overcome at the tip of a chain.

        Of a law that holds ``everywhere``.
        """
        return 0.0, 0.0


class SensingEffect(Effect):
    """A change between the true motor position and the recorded one."""

    counted: ClassVar[bool] = False
    """True where it is of the counter, behind what its disc does: the path has such laws last."""

    def measured(self, position: Expression, p: Parameters) -> Expression:
        """Return the recorded position from the true one, rad."""
        return position

    def folds(self, values: Mapping[str, float]) -> bool:
        """Return whether two positions are recorded alike, or nearly: no record tells where the joint is."""
        return False
