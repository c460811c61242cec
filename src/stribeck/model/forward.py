"""The path run forward: state, contact modes and command in, derivatives and break-away margins out.

State y = [motor positions (n), motor velocities (n), path states]; modes as in :mod:`stribeck.model.dynamics`. The
torque that holds a stuck joint is compared with the level G at zero speed of either direction.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import casadi as ca

from stribeck.errors import StribeckError
from stribeck.model.balance import Balance
from stribeck.model.drive import DRIVE, Drive
from stribeck.model.dynamics import Dynamics
from stribeck.model.path import SignalPath
from stribeck.model.values import Expression

DELAYED = (None, "command", "position")


class Forward:
    """Forward equations of a signal path as CasADi functions of (time, y, modes, command, p).

    Parameters
    ----------
    path : SignalPath
    touching : bool
        Whether the faces of a play are taken as if they met.

    Attributes
    ----------
    size : int
        Length of y.
    """

    def __init__(self, path: SignalPath, *, touching: bool = False) -> None:
        self.path, self.n = path, path.n
        self._dynamics = d = Dynamics(path, touching=touching)
        self.time, self.command = d.time, d.command
        self.y = ca.vertcat(d.q, d.dq, path.x)
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
            (joint, i)
            for i, entry in enumerate(self.path.entries)
            if isinstance(entry.owner, int) and entry.name == "time" and placed[entry.owner].effect.delays
            for joint in placed[entry.owner].joints(self.n)
        )

    @property
    def waves(self) -> tuple[tuple[int, int], ...]:
        """(place in p, multiple) of each frequency, Hz, with which time itself moves the arm."""
        placed = self.path.placed
        return tuple(
            (i, placed[entry.owner].effect.waves)
            for i, entry in enumerate(self.path.entries)
            if isinstance(entry.owner, int) and entry.name == "frequency" and placed[entry.owner].effect.waves
        )

    @property
    def driven(self) -> bool:
        """Whether time itself moves the arm."""
        return bool(ca.depends_on(ca.vertcat(self.rates, self.margins), self.time))

    @cached_property
    def rates(self) -> Any:
        """Time derivative of y, (size, 1)."""
        path, d = self.path, self._dynamics
        out: list[Expression] = [d.slides(j) * d.dq[j] for j in range(self.n)] + list(d.motion.motor)
        for j in path.flexible:
            out += [d.signals[j].link_velocity, d.motion.link[j]]
        for k, place in enumerate(path.placed):
            out += path.rates(k, self.command[place.joint], d.full_signals, d.motion.link, path.x)
        return ca.vertcat(*out)

    @cached_property
    def margins(self) -> Any:
        """Torque left before break-away, forward then backward, (2 n, 1); 1 at a joint with a bristle."""
        motion = self._dynamics.motion
        upward, downward = [], []
        for j in range(self.n):
            if self.bristles[j]:
                upward.append(1.0)
                downward.append(1.0)
                continue
            forward, backward = self._dynamics.levels(j, 0.0, motion.load[j])
            upward.append(forward - motion.needed[j])
            downward.append(backward + motion.needed[j])
        return ca.vertcat(*upward, *downward)

    @property
    def inputs(self) -> list[Any]:
        """Symbols in the order of every function's arguments."""
        return [self.time, self.y, self._dynamics.modes, self.command, self.path.p]

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
        d = self._dynamics
        seen = [self.path.measured(j, d.q[j]) for j in range(self.n)]
        speed = [ca.jacobian(position, d.q[j]) * d.dq[j] for j, position in enumerate(seen)]
        torque = [s.torque for s in d.signals]
        return self._function("sb_outputs", [ca.vertcat(*v) for v in (seen, speed, d.motion.friction, torque)])

    @cached_property
    def true_motion(self) -> ca.Function:
        """(recorded position (n,), recorded velocity (n,), p) -> true position and velocity, each (n,)."""
        seen, speed = ca.SX.sym("seen", self.n), ca.SX.sym("speed", self.n)
        position, velocity = [], []
        for j in range(self.n):
            position.append(self.path.true_position(j, seen[j]))
            velocity.append(speed[j] / self.path.sensed(j, position[j])[0])
        return ca.Function("true_motion", [seen, speed, self.path.p], [ca.vertcat(*position), ca.vertcat(*velocity)])

    @cached_property
    def inertia(self) -> ca.Function:
        """(motor position (n,), p) -> inertia that each joint moves, the others held, (n,)."""
        pose = ca.SX.sym("pose", self.n)
        return ca.Function("inertia", [pose, self.path.p], [self.path.moved_inertia(pose)])

    @cached_property
    def settled(self) -> ca.Function:
        """(recorded position (n,) and velocity (n,), command (n,), p) -> path states with which a motion starts."""
        given = {name: ca.SX.sym(name, self.n) for name in ("position", "velocity", "command")}
        drive = Drive(**{name: given.get(name, ca.SX.zeros(1 if name == "time" else self.n)) for name in DRIVE})
        start = ca.densify(Balance(self.path).start(drive))
        return ca.Function("settled", [*given.values(), self.path.p], [start])

    def _function(self, name: str, results: list[Any]) -> ca.Function:
        return ca.Function(name, self.inputs, ca.cse([ca.densify(result) for result in results]))
