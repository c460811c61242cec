"""The path run forward: state, contact modes and command in, derivatives and break-away margins out.

State y = [motor positions (n), motor velocities (n), path states]. The mode of a joint is -1 or +1 while it slides
and 0 while it sticks: a stuck joint's row is masked, so that its velocity and acceleration are exactly zero, and the
torque that holds it is compared with the level G at zero speed of either direction. A joint whose friction is a
bristle does not stick by itself: mode 0 then clamps it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca

from stribeck.errors import StribeckError
from stribeck.model.cut import DRIVE, Cut, Drive
from stribeck.model.effect import ActuatorEffect, Expression, FrictionEffect, Signals
from stribeck.model.path import SignalPath
from stribeck.model.rigid_body import inverse_dynamics, mass_matrix

NEWTON_STEPS = 4  # load-dependent friction is piecewise linear in the load: Newton's method ends after two or three


DELAYED = (None, "command", "position")


@dataclass(frozen=True)
class _Motion:
    """Accelerations and torques that solve the equations of motion in one mode; lists over joints."""

    motor: list[Expression]
    link: list[Expression]
    load: list[Expression]
    friction: list[Expression]
    needed: list[Expression]


class Forward:
    """Forward equations of a signal path as CasADi functions of (time, y, modes, command, p).

    Parameters
    ----------
    path : SignalPath

    Attributes
    ----------
    size : int
        Length of y.
    """

    def __init__(self, path: SignalPath) -> None:
        self.path, self.n = path, path.n
        self.time = ca.SX.sym("t")
        self.q, self.dq = ca.SX.sym("q", path.n), ca.SX.sym("dq", path.n)
        self.modes, self.command = ca.SX.sym("mode", path.n), ca.SX.sym("u", path.n)
        self.y = ca.vertcat(self.q, self.dq, path.x)
        self.size = self.y.numel()
        for place in path.placed:
            if place.effect.delays not in DELAYED:
                raise StribeckError(f"effect {place.effect.name} delays a signal that the forward path cannot delay")

    @property
    def bristles(self) -> tuple[bool, ...]:
        """Whether each joint's friction is a bristle, which has no stuck mode."""
        return tuple(self.path.bristle(j) is not None for j in range(self.n))

    @property
    def delays(self) -> tuple[tuple[int, int], ...]:
        """(joint, place in p) of each parameter that delays a joint's command.

        A position record that is late is the same thing, seen from the record's own clock.
        """
        placed = self.path.placed
        return tuple(
            (entry.joint, i)
            for i, entry in enumerate(self.path.entries)
            if isinstance(entry.owner, int) and entry.name == "time" and placed[entry.owner].effect.delays
        )

    # --- the stages -------------------------------------------------------------------------------------------

    @cached_property
    def _signals(self) -> list[Signals]:
        """Signals of each joint, acceleration and load apart."""
        path, x = self.path, self.path.x
        signals = []
        for j in range(self.n):
            q, dq = self.q[j], self.dq[j]
            link = (q, dq)
            if j in path.flexible:
                link = (x[path.state_index(f"link[{j}].position")], x[path.state_index(f"link[{j}].velocity")])
            s = Signals(self.time, q, dq, 0.0, *link)
            signals.append(s.at(torque=path.actuated(j, self.command[j], s, x)))
        return signals

    @cached_property
    def _mass(self) -> Any:
        return mass_matrix(self.path.body(), [s.link_position for s in self._signals], prismatic=self.path.prismatic)

    @cached_property
    def _bias(self) -> list[Expression]:
        """Torques on the links without acceleration: gravity, Coriolis and external."""
        path, signals = self.path, self._signals
        positions, velocities = [s.link_position for s in signals], [s.link_velocity for s in signals]
        still = [0.0] * self.n
        bias = inverse_dynamics(path.body(), positions, velocities, still, prismatic=path.prismatic)
        return [bias[j] + path.external(j, s, path.x) for j, s in enumerate(signals)]

    def _transmitted(self, joint: int) -> Expression:
        k, effect = self.path.transmission(joint)  # type: ignore[misc]
        s = self._signals[joint]
        deflection, rate = s.position - s.link_position, s.velocity - s.link_velocity
        return effect.transmitted(deflection, rate, self.path.parameters(k))

    def _levels(self, joint: int, speed: Expression, load: Expression) -> tuple[Expression, Expression]:
        """Return the levels G at a speed, forward and backward."""
        s = self._signals[joint].at(load=load)
        forward, backward = (self.path.level(joint, speed, way, s, self.path.x) for way in (1.0, -1.0))
        return forward, backward

    def _bristle_level(self, joint: int, s: Signals) -> Expression:
        speed = ca.fabs(s.velocity)
        forward, backward = (self.path.level(joint, speed, way, s, self.path.x) for way in (1.0, -1.0))
        return ca.if_else(s.velocity >= 0, forward, backward)

    def _dry(self, joint: int, load: Expression) -> Expression:
        """Return the friction torque without its viscous part while the joint slides."""
        bristle = self.path.bristle(joint)
        if bristle is not None:
            k, effect = bristle
            s = self._signals[joint].at(load=load)
            states, values = self.path.states(k, self.path.x), self.path.parameters(k)
            return effect.bristle_torque(self._bristle_level(joint, s), s, states, values)
        mode = self.modes[joint]
        # mode * v rather than |v|: smooth through zero, so that a trial step past the event keeps its order
        forward, backward = self._levels(joint, mode * self.dq[joint], load)
        return mode * ca.if_else(mode > 0, forward, backward)

    def _slides(self, joint: int) -> Expression:
        return self.modes[joint] ** 2

    # --- the equations of motion ------------------------------------------------------------------------------

    @cached_property
    def motion(self) -> _Motion:
        """The accelerations, with the algebraic loop of load-dependent friction solved."""
        path, n, signals, bias = self.path, self.n, self._signals, self._bias
        transmitted = {j: self._transmitted(j) for j in path.flexible}
        viscous = [path.viscous(j, s, path.x) for j, s in enumerate(signals)]
        driven = [transmitted[j] if j in transmitted else signals[j].torque - viscous[j] for j in range(n)]
        carried = {j: inertia for j in path.flexible if (inertia := path.carrier(j)) is not None}
        for j, inertia in carried.items():
            pull = self._slides(j) * (signals[j].torque - viscous[j] - self._dry(j, 0.0))
            driven[j] = (pull * inertia + path.rotor(j) * transmitted[j]) / self._shared(j, inertia)
        link = self._solve([driven[j] - bias[j] for j in range(n)], transmitted, carried)
        load = [bias[j] + _row(self._mass, j, link) for j in range(n)]
        load = [load[j] if j in carried else transmitted.get(j, load[j]) for j in range(n)]
        motor, friction, needed = list(link), [], []
        for j, s in enumerate(signals):
            dry = self._dry(j, load[j])
            if j in carried:
                motor[j] = self._slides(j) * (link[j] - (transmitted[j] - load[j]) / carried[j])
            elif j in transmitted:
                motor[j] = self._slides(j) * (s.torque - load[j] - viscous[j] - dry) / path.rotor(j)
            hold = s.torque - load[j] - viscous[j]
            needed.append(hold)
            friction.append(viscous[j] + ca.if_else(self._slides(j) > 0, dry, hold))
        return _Motion(motor, link, load, friction, needed)

    def _shared(self, joint: int, inertia: Expression) -> Expression:
        """Return rotor plus carrier inertia, the latter where the joint slides: what divides the link's own push."""
        return self.path.rotor(joint) + self._slides(joint) * inertia + 1e-15

    def _solve(
        self, driving: list[Expression], transmitted: dict[int, Expression], carried: dict[int, Expression]
    ) -> list[Expression]:
        """Return the link accelerations under the driving torques less dry friction."""
        n, path = self.n, self.path
        rigid = [j for j in range(n) if j not in transmitted]
        free = [self._slides(j) if j in rigid else 1.0 for j in range(n)]
        full = ca.SX(self._mass)
        for j in rigid:
            full[j, j] += path.rotor(j)
        for j, inertia in carried.items():  # motor and carrier, between which the torque acts, move with the link
            full[j, j] += path.rotor(j) * inertia / self._shared(j, inertia)
        looped = [j for j in rigid if any(effect.uses_load for _, effect in path.at(j, FrictionEffect))]
        dry = [self._dry(j, 0.0) if j in rigid else 0.0 for j in range(n)]
        right = [free[j] * (driving[j] - dry[j]) for j in range(n)]
        masked = ca.SX(n, n)
        for i in range(n):
            for j in range(n):
                masked[i, j] = free[i] * free[j] * full[i, j] + (1.0 - free[i] if i == j else 0.0)
        link = _solve_symmetric(masked, right)
        if looped:
            link = self._newton(link, full, driving, free, looped, dry)
        return [free[j] * link[j] for j in range(n)]

    def _newton(
        self, start: list[Expression], full: Any, driving: list[Expression], free: list[Expression],
        looped: list[int], dry: list[Expression],
    ) -> list[Expression]:  # fmt: skip
        """Solve full a + dry(load(a)) = driving, load = mass a + bias, by Newton's method on the free rows."""
        n = self.n
        a = ca.SX.sym("a", n)
        torque = list(dry)
        for j in looped:
            torque[j] = self._dry(j, self._bias[j] + _row(self._mass, j, ca.vertsplit(a)))
        balance = ca.mtimes(full, a) + ca.vertcat(*torque) - ca.vertcat(*driving)
        rows = [free[j] * balance[j] + (1.0 - free[j]) * a[j] for j in range(n)]
        system = ca.vertcat(*rows)
        moved = a - ca.solve(ca.jacobian(system, a), system)
        value = ca.vertcat(*start)
        for _ in range(NEWTON_STEPS):
            value = ca.substitute(moved, a, value)
        return list(ca.vertsplit(value))

    # --- derivatives, margins, outputs ------------------------------------------------------------------------

    @cached_property
    def full_signals(self) -> list[Signals]:
        """Signals of every joint with acceleration and load."""
        m = self.motion
        return [s.at(acceleration=m.motor[j], load=m.load[j]) for j, s in enumerate(self._signals)]

    @cached_property
    def rates(self) -> Any:
        """Time derivative of y, (size, 1)."""
        path, m = self.path, self.motion
        out: list[Expression] = [self._slides(j) * self.dq[j] for j in range(self.n)] + list(m.motor)
        for j in path.flexible:
            out += [self._signals[j].link_velocity, m.link[j]]
        for k, place in enumerate(path.placed):
            effect, s = place.effect, self.full_signals[place.joint]
            states, values = path.states(k, path.x), path.parameters(k)
            if isinstance(effect, FrictionEffect) and effect.bristle:
                rates = effect.bristle_derivatives(self._bristle_level(place.joint, s), s, states, values)
            elif effect.states:
                rates = effect.derivatives(s.at(torque=self._upstream(k, s)), states, values)
            else:
                continue
            out += [rates[name] for name in effect.states]
        return ca.vertcat(*out)

    def _upstream(self, k: int, s: Signals) -> Expression:
        """Return the torque that enters the k-th effect: the actuator's output for all but actuator effects."""
        place = self.path.placed[k]
        if not isinstance(place.effect, ActuatorEffect):
            return s.torque
        torque: Expression = self.command[place.joint]
        for other, effect in self.path.at(place.joint, ActuatorEffect):
            if other == k:
                break
            torque = effect.torque(torque, s, self.path.states(other, self.path.x), self.path.parameters(other))
        return torque

    @cached_property
    def margins(self) -> Any:
        """Torque left before break-away, forward then backward, (2 n, 1); 1 at a joint with a bristle."""
        upward, downward = [], []
        for j in range(self.n):
            if self.bristles[j]:
                upward.append(1.0)
                downward.append(1.0)
                continue
            forward, backward = self._levels(j, 0.0, self.motion.load[j])
            upward.append(forward - self.motion.needed[j])
            downward.append(backward + self.motion.needed[j])
        return ca.vertcat(*upward, *downward)

    @property
    def inputs(self) -> list[Any]:
        """Symbols in the order of every function's arguments."""
        return [self.time, self.y, self.modes, self.command, self.path.p]

    @cached_property
    def flow(self) -> ca.Function:
        """(t, y, modes, u, p) -> dy/dt (size,), margins (2 n,)."""
        return self._function("sb_flow", [self.rates, self.margins])

    @cached_property
    def jacobian(self) -> ca.Function:
        """(t, y, modes, u, p) -> d(dy/dt)/d[y, u, t], (size, size + n + 1)."""
        return self._function("sb_jacobian", [ca.jacobian(self.rates, ca.vertcat(self.y, self.command, self.time))])

    @cached_property
    def outputs(self) -> ca.Function:
        """(t, y, modes, u, p) -> recorded position and velocity, friction and actuator torque, each (n,)."""
        seen, speed = [], []
        for j in range(self.n):
            position = self.path.measured(j, self.q[j])
            seen.append(position)
            speed.append(ca.jacobian(position, self.q[j]) * self.dq[j])
        torque = [s.torque for s in self._signals]
        return self._function("sb_outputs", [ca.vertcat(*v) for v in (seen, speed, self.motion.friction, torque)])

    @cached_property
    def true_motion(self) -> ca.Function:
        """(recorded position (n,), recorded velocity (n,), p) -> true position and velocity, each (n,)."""
        seen, speed = ca.SX.sym("seen", self.n), ca.SX.sym("speed", self.n)
        position, velocity = [], []
        for j in range(self.n):
            true = self.path.true_position(j, seen[j])
            position.append(true)
            velocity.append(ca.jacobian(true, seen[j]) * speed[j])
        return ca.Function("true_motion", [seen, speed, self.path.p], [ca.vertcat(*position), ca.vertcat(*velocity)])

    @cached_property
    def inertia(self) -> ca.Function:
        """(motor position (n,), p) -> inertia that each joint moves, the others held, (n,)."""
        pose = ca.SX.sym("pose", self.n)
        mass = mass_matrix(self.path.body(), ca.vertsplit(pose), prismatic=self.path.prismatic)
        rotors = ca.vertcat(*[self.path.rotor(j) for j in range(self.n)])
        return ca.Function("inertia", [pose, self.path.p], [ca.diag(mass) + rotors])

    @cached_property
    def settled(self) -> ca.Function:
        """(recorded position (n,) and velocity (n,), command (n,), p) -> path states with which a motion starts."""
        given = {name: ca.SX.sym(name, self.n) for name in ("position", "velocity", "command")}
        drive = Drive(**{name: given.get(name, ca.SX.zeros(1 if name == "time" else self.n)) for name in DRIVE})
        start = ca.densify(Cut(self.path, 1e-3).start(drive))
        return ca.Function("settled", [*given.values(), self.path.p], [start])

    def _function(self, name: str, results: list[Any]) -> ca.Function:
        return ca.Function(name, self.inputs, ca.cse([ca.densify(result) for result in results]))


def _row(matrix: Any, j: int, values: Sequence[Expression]) -> Expression:
    total: Expression = 0.0
    for i, value in enumerate(values):
        total = total + matrix[j, i] * value
    return total


def _solve_symmetric(matrix: Any, right: list[Expression]) -> list[Expression]:
    """Solve a symmetric positive definite system by symbolic L D L': n^3/6 operations, no pivots needed."""
    n = len(right)
    a = [[matrix[i, j] for j in range(n)] for i in range(n)]
    b = list(right)
    for k in range(n):
        for i in range(k + 1, n):
            factor = a[i][k] / a[k][k]
            for j in range(k + 1, i + 1):
                a[i][j] = a[i][j] - factor * a[j][k]
            b[i] = b[i] - factor * b[k]
    for k in reversed(range(n)):
        for i in range(k + 1, n):
            b[k] = b[k] - a[i][k] * b[i]
        b[k] = b[k] / a[k][k]
    return b
