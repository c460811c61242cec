"""The signal path of one arm: the stages, composed with any list of effects, as CasADi expressions.

The path is cut or run forward by :mod:`stribeck.model.cut` and :mod:`stribeck.model.forward`; both take the
stages from here, so that no law is written twice.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import casadi as ca

from stribeck.arm import Arm
from stribeck.errors import StribeckError
from stribeck.model.effect import (
    ActuatorEffect,
    ExternalEffect,
    FrictionEffect,
    RigidBodyEffect,
    SensingEffect,
    StandEffect,
    TransmissionEffect,
)
from stribeck.model.layout import Placed, layout
from stribeck.model.rigid_body import base_force
from stribeck.model.stand import Stand
from stribeck.model.tip import tip_of
from stribeck.model.tustin import tustin_level, tustin_viscous
from stribeck.model.values import Body, Expression, Parameters, Signals, States

INVERSION_STEPS = 4  # fixed-point steps that undo a sensor's law; the error falls by its slope at each


class SignalPath:
    """The stages of an arm with effects, over symbols for all parameters and states.

    Parameters
    ----------
    arm : Arm
        The nominal arm; its own ``effects`` entries are not read here.
    placed : sequence of Placed
        The effects, in the order in which their stage applies them.

    Attributes
    ----------
    entries : tuple of Entry
        The parameters, in the order of ``p``.
    p : casadi.SX (p, 1)
        Their symbols, physical values.
    flexible : tuple of int
        Joints whose link moves apart from its motor.
    x : casadi.SX (nx, 1)
        States: link position and velocity of each flexible joint, then the effects' states in order.
    """

    def __init__(self, arm: Arm, placed: Sequence[Placed] = ()) -> None:
        self.arm = arm
        self.placed = tuple(placed)
        self.n = arm.n
        self.prismatic = arm.joints[0].kind == "prismatic"
        self.entries = layout(arm, placed)
        self.p = ca.SX.sym("p", len(self.entries))
        self._index = {entry.key: i for i, entry in enumerate(self.entries)}
        self.flexible = self._flexible()
        self.state_names = self._state_names()
        self.x = ca.SX.sym("x", len(self.state_names))

    def _flexible(self) -> tuple[int, ...]:
        joints = [place.joint for place in self.placed if isinstance(place.effect, TransmissionEffect)]
        if len(set(joints)) != len(joints):
            raise StribeckError("two transmission effects at one joint", do="keep one of them")
        return tuple(sorted(joints))

    @property
    def rough(self) -> float:
        """Relative step over which a residual along the path is smooth; 0 where its derivatives are."""
        return max((e.effect.rough for e in self.placed if isinstance(e.effect, TransmissionEffect)), default=0.0)

    @property
    def shifts(self) -> tuple[int, ...]:
        """Indices of the parameters that move a recorded position in time, and with it every reversal of friction."""
        late = {k for k, place in enumerate(self.placed) if place.effect.delays == "position"}
        return tuple(i for i, entry in enumerate(self.entries) if entry.owner in late and entry.name == "time")

    def _state_names(self) -> tuple[str, ...]:
        links = [f"link[{j}].{what}" for j in self.flexible for what in ("position", "velocity")]
        own = [f"{k}.{state}" for k, place in enumerate(self.placed) for state in place.effect.states]
        return tuple(links + own)

    def parameter(self, key: str) -> ca.SX:
        """Return the symbol of one parameter by its key."""
        return self.p[self._index[key]]

    def parameters(self, k: int) -> Parameters:
        """Return the symbols of the k-th placed effect by parameter name."""
        return {entry.name: self.p[i] for i, entry in enumerate(self.entries) if entry.owner == k}

    def states(self, k: int, x: Any) -> States:
        """Return the k-th placed effect's states by name, out of the state vector ``x``."""
        prefix = f"{k}."
        return {name.removeprefix(prefix): x[i] for i, name in enumerate(self.state_names) if name.startswith(prefix)}

    def state_index(self, name: str) -> int:
        """Return the place of a state in ``x``."""
        return self.state_names.index(name)

    def at(self, joint: int, kind: type[Any]) -> list[tuple[int, Any]]:
        """Return (number, effect) of the placed effects of one kind at a joint."""
        here = [(k, place.effect) for k, place in enumerate(self.placed) if joint in place.joints(self.n)]
        return [(k, effect) for k, effect in here if isinstance(effect, kind)]

    def constants(self, joint: int, direction: float) -> Parameters:
        """Return the Tustin constants' symbols of a joint for one direction of motion."""
        name = self.arm.names[joint]
        side = "backward" if direction < 0 and f"{name}.backward.C0" in self._index else "friction"
        return {key: self.parameter(f"{name}.{side}.{key}") for key in ("C0", "C1", "C2", "alpha")}

    def _constants(self, joint: int, direction: float, s: Signals, x: Any) -> Parameters:
        """Return the Tustin constants after the effects that change them."""
        constants = self.constants(joint, direction)
        for k, effect in self.at(joint, FrictionEffect):
            constants = effect.constants(constants, s, self.states(k, x), self.parameters(k))
        return constants

    def rotor(self, joint: int) -> ca.SX:
        """Return the rotor inertia's symbol; a prismatic axis carries it as reflected mass."""
        return self.parameter(f"{self.arm.names[joint]}.rotor_inertia")

    def body(self) -> Body:
        """Return the rigid body after all rigid-body effects."""
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

    def actuated(self, joint: int, command: Expression, s: Signals, x: Any) -> Expression:
        """Return the actuator's torque from the command, N m."""
        torque = command
        for k, effect in self.at(joint, ActuatorEffect):
            torque = effect.torque(torque, s, self.states(k, x), self.parameters(k))
        return torque

    def command_scale(self, joint: int, position: Expression) -> Expression:
        """Return d(torque)/d(command) of a joint's actuator at a position."""
        scale: Expression = 1.0
        for k, effect in self.at(joint, ActuatorEffect):
            scale = scale * effect.command_scale(position, self.parameters(k))
        return scale

    def level(self, joint: int, speed: Expression, direction: float, s: Signals, x: Any) -> Expression:
        """Return the sliding friction level G (N m) of a joint at a speed for one direction."""
        constants = self._constants(joint, direction, s, x)
        for k, effect in self.at(joint, FrictionEffect):
            speed = effect.speed(speed, s, self.states(k, x), self.parameters(k))
        level = tustin_level(speed, constants)
        for k, effect in self.at(joint, FrictionEffect):
            level = effect.level(level, direction, s, self.states(k, x), self.parameters(k))
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
        for k, effect in self.at(joint, FrictionEffect):
            torque = effect.viscous(torque, s, self.states(k, x), self.parameters(k))
        return torque

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
                    tip, levers = tip_of(self.body().length, motion)
                    fx, fy = place.effect.tip_force(tip, *given)
                    torques = [torque + rx * fy - ry * fx for torque, (rx, ry) in zip(torques, levers, strict=True)]
        return torques

    @property
    def sliding(self) -> tuple[int, StandEffect] | None:
        """Number and effect of the stand that slides, if there is one."""
        found = [(k, place.effect) for k, place in enumerate(self.placed) if isinstance(place.effect, StandEffect)]
        if len(found) > 1:
            raise StribeckError("two stands under one arm", do="keep one of them")
        return found[0] if found else None

    def stand(self, motion: Sequence[Signals], x: Any) -> Stand | None:
        """Return the stand under the links as they move; None on firm ground."""
        found = self.sliding
        if found is None:
            return None
        k, effect = found
        p = self.parameters(k)
        q, dq = [s.link_position for s in motion], [s.link_velocity for s in motion]
        force, coupling, mass = base_force(self.body(), q, dq, effect.way(p))
        whole = mass + effect.mass(p)
        return Stand((effect.force(self.states(k, x), p) - force) / whole, ca.SX(ca.vertcat(*coupling)), whole)

    def rates(
        self, k: int, command: Expression, motion: Sequence[Signals], links: Sequence[Expression], x: Any
    ) -> list[Expression]:
        """Return the time derivatives of the k-th placed effect's states, in order.

        ``motion`` and ``links``, their accelerations (rad/s^2), are those of all joints.
        """
        effect, states, values = self.placed[k].effect, self.states(k, x), self.parameters(k)
        if not effect.states:
            return []
        if isinstance(effect, StandEffect):
            stand = self.stand(motion, x)
            assert stand is not None
            return [states["velocity"], stand.acceleration(links)]
        s = motion[self.placed[k].joint]
        if isinstance(effect, FrictionEffect) and effect.bristle:
            level = self.present_level(self.placed[k].joint, s, x)
            rates = effect.bristle_derivatives(level, s, states, values)
        else:
            rates = effect.derivatives(s.at(torque=self._upstream(k, command, s, x)), states, values)
        return [rates[name] for name in effect.states]

    def _upstream(self, k: int, command: Expression, s: Signals, x: Any) -> Expression:
        """Return the torque that enters the k-th effect: the actuator's output for all but actuator effects."""
        if not isinstance(self.placed[k].effect, ActuatorEffect):
            return s.torque
        torque = command
        for other, effect in self.at(self.placed[k].joint, ActuatorEffect):
            if other == k:
                break
            torque = effect.torque(torque, s, self.states(other, x), self.parameters(other))
        return torque

    def transmission(self, joint: int) -> tuple[int, TransmissionEffect] | None:
        """Return (number, effect) of a joint's compliance, if it has one."""
        found = self.at(joint, TransmissionEffect)
        return found[0] if found else None

    def carrier(self, joint: int) -> Expression | None:
        """Return the inertia of what carries a joint's motor where that yields, kg m^2."""
        k, effect = self.transmission(joint)  # type: ignore[misc]
        return effect.carrier(self.parameters(k))

    def measured(self, joint: int, position: Expression) -> Expression:
        """Return the recorded position of a joint from the true one, rad."""
        for k, effect in self.at(joint, SensingEffect):
            position = effect.measured(position, self.parameters(k))
        return position

    def true_position(self, joint: int, recorded: Expression) -> Expression:
        """Return the true position of a joint from the recorded one, by fixed-point inversion, rad."""
        if not self.at(joint, SensingEffect):
            return recorded
        position = recorded
        for _ in range(INVERSION_STEPS):
            position = recorded - (self.measured(joint, position) - position)
        return position
