"""The signal path of one arm: the stages, composed with any list of effects, as CasADi expressions.

The path is cut or run forward by :mod:`stribeck.model.cut` and :mod:`stribeck.model.forward`; both take the
stages from here, so that no law is written twice.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import casadi as ca

from stribeck.model.effect import (
    ActuatorEffect,
    ExternalEffect,
    FrictionEffect,
    RigidBodyEffect,
    StandEffect,
    TransmissionEffect,
)
from stribeck.model.rigid_body import base_force, inverse_dynamics, mass_matrix
from stribeck.model.sensors import Sensors
from stribeck.model.stand import Stand
from stribeck.model.tip import tip_of
from stribeck.model.tustin import tustin_level, tustin_viscous
from stribeck.model.values import Body, Expression, Parameters, Signals

SHORTEST = 1e-9  # s, of a past that has a speed


class SignalPath(Sensors):
    """The stages of an arm with effects, over the symbols for all parameters and states."""

    def _constants(self, joint: int, direction: float, s: Signals, x: Any) -> Parameters:
        """Return the Tustin constants after the effects that change them."""
        constants = self.constants(joint, direction)
        for k, effect in self._friction(joint):
            constants = effect.constants(constants, s, self.states(k, x), self.parameters(k))
        return constants

    def rotor(self, joint: int) -> ca.SX:
        """Return the rotor inertia's symbol; a prismatic axis carries it as reflected mass."""
        return self.parameter(f"{self.arm.names[joint]}.rotor_inertia")

    @cached_property
    def body(self) -> Body:
        """The rigid body after all rigid-body effects."""
        names, joints = self.arm.names, self.arm.joints
        column = {
            key: tuple(self.parameter(f"{name}.{key}") for name in names)
            for key in ("mass", "com_x", "com_y", "inertia")
        }
        body = Body(**column, length=tuple(joint.length for joint in joints), gravity=self.arm.gravity)
        for k, place in enumerate(self.placed):
            if isinstance(place.effect, RigidBodyEffect):
                body = place.effect.body(body, place.joint, self.parameters(k))
        return body

    def moved_inertia(self, pose: ca.SX) -> ca.SX:
        """Return the inertia (n, 1) that each joint moves in a pose (n, 1), the others held, rotors included."""
        mass = mass_matrix(self.body, ca.vertsplit(pose), prismatic=self.prismatic)
        return ca.diag(mass) + ca.vertcat(*[self.rotor(j) for j in range(self.n)])

    def actuated(self, joint: int, command: Expression, s: Signals, x: Any) -> Expression:
        """Return the actuator's torque from the command, N m."""
        torque = command
        for k, effect in self._drive(joint):
            torque = effect.torque(torque, s, self.states(k, x), self.parameters(k))
        return torque

    def _drive(self, joint: int) -> list[tuple[int, ActuatorEffect]]:
        """Return (number, effect) of a joint's actuator effects from the command to the shaft."""
        return sorted(self.at(joint, ActuatorEffect), key=lambda found: found[1].along)

    def command_scale(self, joint: int, position: Expression) -> Expression:
        """Return d(torque)/d(command) of a joint's actuator at a position; at most 1 where some of it is lost."""
        effects, scale = self.at(joint, ActuatorEffect), ca.SX(1.0)
        for k, effect in effects:
            scale = scale * effect.command_scale(position, self.parameters(k))
        return ca.fmin(scale, 1.0) if any(effect.clips for _, effect in effects) else scale

    def torque_left(self, joint: int, s: Signals, x: Any) -> Expression:
        """Return what friction that goes with the torque of the motor leaves of more of it: 1 where none does.

        Residuals are divided by it, as by :meth:`command_scale`: noise in the command would grow less with the share.
        """
        if not any(effect.uses_torque for _, effect in self.at(joint, FrictionEffect)):
            return 1.0
        torque = ca.SX.sym("torque")
        slope = ca.jacobian(self.present_level(joint, s.at(torque=torque), x), torque)
        return 1.0 - ca.sign(s.velocity) * ca.substitute(slope, torque, s.torque)

    def _friction(self, joint: int) -> list[tuple[int, FrictionEffect]]:
        """Return (number, effect) of a joint's laws of friction, those that change what others make of it last."""
        return sorted(self.at(joint, FrictionEffect), key=lambda found: found[1].upon)

    def level(self, joint: int, speed: Expression, direction: float, s: Signals, x: Any) -> Expression:
        """Return the sliding friction level G (N m) of a joint at a speed for one direction.

        Parameters
        ----------
        joint : int
        speed : expression
            rad/s, at least 0.
        direction : float
            1 or -1.
        s : Signals
            Of the joint.
        x : casadi.SX (nx, 1)
            State vector.
        """
        constants = self._constants(joint, direction, s, x)
        s = s.at(viscous=self.viscous(joint, s, x))
        asked = s.at(velocity=direction * speed)
        for k, effect in self._friction(joint):
            speed = effect.speed(speed, s, self.states(k, x), self.parameters(k))
        level = tustin_level(speed, constants)
        for k, effect in self._friction(joint):
            level = effect.level(level, direction, asked, self.states(k, x), self.parameters(k))
        return level

    def present_level(self, joint: int, s: Signals, x: Any) -> Expression:
        """Return the sliding friction level G (N m) of a joint at its own speed and direction."""
        speed = ca.fabs(s.velocity)
        forward, backward = (self.level(joint, speed, way, s, x) for way in (1.0, -1.0))
        return ca.if_else(s.velocity >= 0, forward, backward)

    def viscous(self, joint: int, s: Signals, x: Any) -> Expression:
        """Return the friction torque of a joint that has no sign function, N m."""
        forward, backward = (self._constants(joint, way, s, x)["C2"] for way in (1.0, -1.0))
        torque = tustin_viscous(s.velocity, forward, backward)
        for k, effect in self._friction(joint):
            torque = effect.viscous(torque, s, self.states(k, x), self.parameters(k))
        return torque

    def rubbing(self, k: int, s: Signals, x: Any) -> Signals:
        """Return signals with the size of a joint's sliding friction, N m, where the k-th effect goes with it."""
        joint, effect = self.placed[k].joint, self.placed[k].effect
        if not isinstance(effect, FrictionEffect) or not effect.uses_friction:
            return s
        return s.at(friction=self.present_level(joint, s, x) + ca.fabs(self.viscous(joint, s, x)))

    def rubbed(self, k: int, s: Signals, x: Any) -> Signals:
        """Return the same with the friction of the past, at its mean speed and that of both directions."""
        speed = (s.travelled + s.led) / ca.fmax(s.recorded + s.lead, SHORTEST)
        ways = [self.rubbing(k, s.at(velocity=way * speed), x).friction for way in (1.0, -1.0)]
        return s.at(friction=0.5 * (ways[0] + ways[1]))

    def bristle(self, joint: int) -> tuple[int, FrictionEffect] | None:
        """Return (number, effect) of the bristle that carries a joint's friction, if there is one."""
        found = [(k, effect) for k, effect in self.at(joint, FrictionEffect) if effect.bristle]
        return found[0] if found else None

    def external(self, motion: Sequence[Signals], x: Any) -> list[Expression]:
        """Return the torques on the links from outside the model, N m."""
        torques: list[Expression] = [0.0] * self.n
        for k, place in enumerate(self.placed):
            if isinstance(place.effect, ExternalEffect):
                given = self.states(k, x), self.parameters(k)
                for j in place.joints(self.n):
                    torques[j] = torques[j] + place.effect.torque(motion[j], *given)
                if place.effect.everywhere:
                    tip, levers = tip_of(self.body.length, motion)
                    fx, fy = place.effect.tip_force(tip, *given)
                    torques = [torque + rx * fy - ry * fx for torque, (rx, ry) in zip(torques, levers, strict=True)]
        return torques

    def weighed(self, motion: Sequence[Signals], x: Any, *, level: bool = False) -> list[Signals]:
        """Return the joints' signals with the torque that gravity asks for, where a law of friction goes with it."""
        if not any(isinstance(place.effect, FrictionEffect) and place.effect.uses_weight for place in self.placed):
            return list(motion)
        still, q = [0.0] * self.n, self.angles(motion, x, level=level)[0]
        weights = inverse_dynamics(self.body, q, still, still, prismatic=self.prismatic)
        return [s.at(weight=weight) for s, weight in zip(motion, weights, strict=True)]

    def stand(self, motion: Sequence[Signals], x: Any, *, level: bool = False) -> Stand | None:
        """Return the stand under the links as they move; None on firm ground. It may be taken as ``level``."""
        found = self.sliding
        if found is None:
            return None
        k, effect = found
        p, body = self.parameters(k), self.body
        q, dq = self.angles(motion, x, level=level)
        force, across, mass = base_force(body, q, dq, effect.way(p))
        still = [0.0] * self.n
        turn, coupling, whole = effect.turn(p), across, mass + effect.mass(p)
        inertia = mass_matrix(body, q)[:, 0]
        force = force + turn * inverse_dynamics(body, q, dq, still)[0]
        whole = whole + turn * (2.0 * coupling[0] + turn * inertia[0])
        return Stand((effect.force(self.states(k, x), p) - force) / whole, coupling + turn * inertia, whole)

    def angles(
        self, motion: Sequence[Signals], x: Any, *, level: bool = False
    ) -> tuple[list[Expression], list[Expression]]:
        """Return the links' relative angles and velocities (n each), the first one's against firm ground.

        A stand may be taken as ``level``, as it is along a recording: that it tilts then changes no pose, and what a
        step needs is known ahead. Of a tilt of some degrees, a seventh of the effect is left.
        """
        q, dq = [s.link_position for s in motion], [s.link_velocity for s in motion]
        if self.sliding is not None and not level:
            k, effect = self.sliding
            turn, states = effect.turn(self.parameters(k)), self.states(k, x)
            q[0], dq[0] = q[0] + turn * states["position"], dq[0] + turn * states["velocity"]
        return q, dq

    def rates(
        self, k: int, command: Expression, motion: Sequence[Signals], links: Sequence[Expression], x: Any,
        *, level: bool = False,
    ) -> list[Expression]:  # fmt: skip
        """Return the time derivatives of the k-th placed effect's states, in order.

        Parameters
        ----------
        k : int
            Place of the effect in the list.
        command : expression
            Of its joint, N m.
        motion : sequence of Signals
            Of all joints.
        links : sequence of n expressions
            Accelerations of the links, rad/s^2.
        x : casadi.SX (nx, 1)
            State vector.
        level : bool
            As of :meth:`stand`.
        """
        effect, states, values = self.placed[k].effect, self.states(k, x), self.parameters(k)
        if not effect.states:
            return []
        if isinstance(effect, StandEffect):
            stand = self.stand(motion, x, level=level)
            assert stand is not None
            return [states["velocity"], stand.acceleration(links)]
        s = motion[self.placed[k].joint]
        if isinstance(effect, FrictionEffect) and effect.bristle:
            level = self.present_level(self.placed[k].joint, s, x)
            rates = effect.bristle_derivatives(level, s, states, values)
        else:
            s = s.at(torque=self.entering(k, command, s, x))
            rates = effect.derivatives(self.rubbing(k, s, x), states, values)
        return [rates[name] for name in effect.states]

    def entering(self, k: int, command: Expression, s: Signals, x: Any) -> Expression:
        """Return the torque that enters the k-th effect: the actuator's output for all but actuator effects."""
        joint, effect = self.placed[k].joint, self.placed[k].effect
        if not isinstance(effect, ActuatorEffect):
            return self.actuated(joint, command, s, x)
        torque = command
        for other, before in self._drive(joint):
            if other == k:
                break
            torque = before.torque(torque, s, self.states(other, x), self.parameters(other))
        return torque

    def transmission(self, joint: int) -> tuple[int, TransmissionEffect] | None:
        """Return (number, effect) of a joint's compliance, if it has one."""
        found = self.at(joint, TransmissionEffect)
        return found[0] if found else None

    def carrier(self, joint: int) -> Expression | None:
        """Return the inertia of what carries a joint's motor where that yields, kg m^2."""
        k, effect = self.transmission(joint)  # type: ignore[misc]
        return effect.carrier(self.parameters(k))
