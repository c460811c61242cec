"""The equations of motion in one contact mode: accelerations and torques from positions, velocities and command.

The mode of a joint is -1 or +1 while it slides and 0 while it sticks: a stuck joint's row is masked, so that its
acceleration is exactly zero. A joint whose friction is a bristle does not stick by itself: mode 0 then clamps it.

A bristle's level that grows with the load takes it without what the bristle's damping keeps from it (while the joints
beside slide). Under all of the load a fast joint that brakes would have up to three accelerations in balance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca

from stribeck.model.bisect import bisected
from stribeck.model.effect import FrictionEffect
from stribeck.model.path import SignalPath
from stribeck.model.rigid_body import inverse_dynamics, mass_matrix
from stribeck.model.stand import Stand
from stribeck.model.values import Expression, Signals

NEWTON_STEPS = 4  # load-dependent friction is piecewise linear in the load: Newton's method ends after two or three
BISECTIONS = 20  # before them, where a bristle's damping has knees and joints beside it stick
HEAVY = 1e9  # N m, under which no bristle slides


@dataclass(frozen=True)
class Motion:
    """Accelerations and torques that solve the equations of motion in one mode; lists over joints.

    The load is what the link takes; ``loading`` is the load that the level of friction goes with.
    """

    motor: list[Expression]
    link: list[Expression]
    load: list[Expression]
    loading: list[Expression]
    friction: list[Expression]
    needed: list[Expression]


class Dynamics:
    """Equations of motion of a signal path, over symbols for its state and drive.

    Parameters
    ----------
    path : SignalPath
    touching : bool
        Whether the faces of a play are taken as if they met.

    Attributes
    ----------
    time : casadi.SX (1, 1)
        s.
    q, dq : casadi.SX (n, 1)
        Motor positions and velocities.
    modes : casadi.SX (n, 1)
        -1, 0 or +1.
    command : casadi.SX (n, 1)
        Commanded torques, N m.
    """

    def __init__(self, path: SignalPath, *, touching: bool = False) -> None:
        self.path, self.n, self._touching = path, path.n, touching
        self.time = ca.SX.sym("t")
        self.q, self.dq = ca.SX.sym("q", path.n), ca.SX.sym("dq", path.n)
        self.modes, self.command = ca.SX.sym("mode", path.n), ca.SX.sym("u", path.n)

    # --- the stages -------------------------------------------------------------------------------------------

    @cached_property
    def signals(self) -> list[Signals]:
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
        return path.weighed(signals, x)

    @cached_property
    def _mass(self) -> Any:
        path, stand = self.path, self._stand
        mass = mass_matrix(path.body, path.angles(self.signals, path.x)[0], prismatic=path.prismatic)
        return mass if stand is None else stand.inertia(mass)

    @cached_property
    def _stand(self) -> Stand | None:
        return self.path.stand(self.signals, self.path.x)

    @cached_property
    def _bias(self) -> list[Expression]:
        """Torques on the links without acceleration: gravity, Coriolis and external."""
        path, signals = self.path, self.signals
        positions, velocities = path.angles(signals, path.x)
        still = [0.0] * self.n
        bias = inverse_dynamics(path.body, positions, velocities, still, prismatic=path.prismatic)
        external = path.external(signals, path.x)
        bias = [bias[j] + external[j] for j in range(self.n)]
        return bias if self._stand is None else self._stand.loads(bias, still)

    def _transmitted(self, joint: int) -> Expression:
        k, effect = self.path.transmission(joint)  # type: ignore[misc]
        s = self.signals[joint]
        deflection, rate = s.position - s.link_position, s.velocity - s.link_velocity
        if self._touching and effect.zone:
            stiffness, damping = effect.touching(deflection, rate, self.path.parameters(k))
            return stiffness * deflection + damping * rate
        return effect.transmitted(deflection, rate, self.path.parameters(k))

    def levels(self, joint: int, speed: Expression, load: Expression) -> tuple[Expression, Expression]:
        """Return the levels G at a speed, forward and backward."""
        s = self.signals[joint].at(load=load)
        forward, backward = (self.path.level(joint, speed, way, s, self.path.x) for way in (1.0, -1.0))
        return forward, backward

    def _dry(self, joint: int, load: Expression) -> Expression:
        """Return the friction torque without its viscous part while the joint slides."""
        if self.path.bristle(joint) is not None:
            return self._bristle(joint, load)
        mode = self.modes[joint]
        # mode * v rather than |v|: smooth through zero, so that a trial step past the event keeps its order
        forward, backward = self.levels(joint, mode * self.dq[joint], load)
        return mode * ca.if_else(mode > 0, forward, backward)

    def _bristle(self, joint: int, load: Expression, *, damped: bool = True) -> Expression:
        """Return the torque of a joint's bristle, or of its spring alone."""
        k, effect = self.path.bristle(joint)  # type: ignore[misc]
        s = self.signals[joint].at(load=load)
        states, values = self.path.states(k, self.path.x), self.path.parameters(k)
        if not damped:
            values = {**values, "damping": 0.0}
        return effect.bristle_torque(self.path.present_level(joint, s, self.path.x), s, states, values)

    def slides(self, joint: int) -> Expression:
        """Return 1 while a joint slides, 0 while it sticks."""
        return self.modes[joint] ** 2

    # --- solved -----------------------------------------------------------------------------------------------

    @cached_property
    def motion(self) -> Motion:
        """The accelerations, with the algebraic loop of load-dependent friction solved."""
        path, n, signals, bias = self.path, self.n, self.signals, self._bias
        transmitted = {j: self._transmitted(j) for j in path.flexible}
        viscous = [path.viscous(j, s, path.x) for j, s in enumerate(signals)]
        driven = [transmitted[j] if j in transmitted else signals[j].torque - viscous[j] for j in range(n)]
        carried = {j: inertia for j in path.flexible if (inertia := path.carrier(j)) is not None}
        for j, inertia in carried.items():
            pull = self.slides(j) * (signals[j].torque - viscous[j])
            driven[j] = (pull * inertia + path.rotor(j) * transmitted[j]) / self._shared(j, inertia)
        link, held = self._solve([driven[j] - bias[j] for j in range(n)], transmitted, carried)
        load = self._loads(link)
        load = [load[j] if j in carried else transmitted.get(j, load[j]) for j in range(n)]
        loading = [held.get(j, load[j]) for j in range(n)]
        motor, friction, needed = list(link), [], []
        for j, s in enumerate(signals):
            dry = self._dry(j, loading[j])
            if j in carried:
                motor[j] = self.slides(j) * (link[j] - (transmitted[j] - load[j]) / carried[j])
            elif j in transmitted:
                motor[j] = self.slides(j) * (s.torque - load[j] - viscous[j] - dry) / path.rotor(j)
            hold = s.torque - load[j] - viscous[j]
            needed.append(hold)
            friction.append(viscous[j] + ca.if_else(self.slides(j) > 0, dry, hold))
        return Motion(motor, link, load, loading, friction, needed)

    def _loads(self, link: Sequence[Expression]) -> list[Expression]:
        """Return the torques that rigid links take at their accelerations."""
        return [self._bias[j] + _row(self._mass, j, link) for j in range(self.n)]

    def _shared(self, joint: int, inertia: Expression) -> Expression:
        """Return rotor plus carrier inertia, the latter where the joint slides: what divides the link's own push."""
        return self.path.rotor(joint) + self.slides(joint) * inertia + 1e-15

    def _solve(
        self, driving: list[Expression], transmitted: dict[int, Expression], carried: dict[int, Expression]
    ) -> tuple[list[Expression], dict[int, Expression]]:
        """Return the link accelerations under the driving torques less dry friction, and what loads the bristles."""
        n, path = self.n, self.path
        rigid = [j for j in range(n) if j not in transmitted]
        free = [self.slides(j) if j in rigid else 1.0 for j in range(n)]
        weights = [1.0 if j in rigid else 0.0 for j in range(n)]  # of dry friction, in what drives each link
        full = ca.SX(self._mass)
        for j in rigid:
            full[j, j] += path.rotor(j)
        for j, inertia in carried.items():  # motor and carrier, between which the torque acts, move with the link
            full[j, j] += path.rotor(j) * inertia / self._shared(j, inertia)
            weights[j] = self.slides(j) * inertia / self._shared(j, inertia)
        rubbing = [*rigid, *carried]
        looped = [j for j in rubbing if any(effect.uses_load for _, effect in path.at(j, FrictionEffect))]
        sprung = [j for j in looped if path.bristle(j) is not None]
        dry = [self._dry(j, 0.0) if j in rubbing else 0.0 for j in range(n)]
        for j in sprung:
            dry[j] = self._bristle(j, 0.0, damped=False)
        masked = _masked(full, free)

        def under(dry: list[Expression]) -> list[Expression]:
            return _solve_symmetric(masked, [free[j] * (driving[j] - weights[j] * dry[j]) for j in range(n)])

        link, held = under(dry), dict[int, Expression]()
        if looped:
            near, kept = list(dry), {j: self._kept(j, full, free, weights, sprung) for j in sprung}
            for j in sprung:
                pushed = _solve_symmetric(masked, [free[j] * weights[j] * float(k == j) for k in range(n)])
                near[j] = self._near(j, self._loads(link)[j], _row(self._mass, j, pushed) - kept[j][j], dry[j])
            start = [*under(near), *[near[j] - dry[j] for j in sprung]]
            link, held = self._newton(start, full, driving, free, weights, looped, dry, kept)
        return [free[j] * link[j] for j in range(n)], held

    def _kept(
        self, joint: int, full: Any, free: list[Expression], weights: list[Expression], sprung: list[int]
    ) -> list[Expression]:
        """Return what a joint's torque takes from the loads of all while the joints without bristles slide."""
        held = [free[j] if j in sprung else 1.0 for j in range(self.n)]
        push = held[joint] * weights[joint]
        pushed = _solve_symmetric(_masked(full, held), [push * float(j == joint) for j in range(self.n)])
        return [_row(self._mass, j, pushed) for j in range(self.n)]

    def _near(self, joint: int, load: Expression, share: Expression, spring: Expression) -> Expression:
        """Return a bristle's torque under a load less that share of its damping."""
        ends = [self._dry(joint, end) - spring for end in (load, 0.0, -HEAVY, HEAVY)]
        reach = share * ca.mmax(ca.fabs(ca.vertcat(*ends)))
        found = bisected(lambda x: x - load + share * (self._dry(joint, x) - spring), load, reach, BISECTIONS)
        return self._dry(joint, found)

    def _newton(
        self, start: list[Expression], full: Any, driving: list[Expression], free: list[Expression],
        weights: list[Expression], looped: list[int], dry: list[Expression], kept: dict[int, list[Expression]],
    ) -> tuple[list[Expression], dict[int, Expression]]:  # fmt: skip
        """Solve full a + weights dry(load(a)) = driving, load = mass a + bias, by Newton's method on the free rows.

        A bristle's damping, beside its spring in ``dry``, is unknown, too: what it keeps from the loads is added.
        """
        n = self.n
        sprung = list(kept)
        a, damping = ca.SX.sym("a", n), ca.SX.sym("damping", len(sprung))
        load = self._loads(ca.vertsplit(a))
        for i, j in enumerate(sprung):
            load = [load[k] + kept[j][k] * damping[i] if k in sprung else load[k] for k in range(n)]
        torque = [self._dry(j, load[j]) if j in looped else dry[j] for j in range(n)]
        balance = ca.mtimes(full, a) + ca.vertcat(*weights) * ca.vertcat(*torque) - ca.vertcat(*driving)
        rows = [free[j] * balance[j] + (1.0 - free[j]) * a[j] for j in range(n)]
        rows += [damping[i] - (torque[j] - dry[j]) for i, j in enumerate(sprung)]
        unknown, system = ca.vertcat(a, damping), ca.vertcat(*rows)
        moved = unknown - ca.solve(ca.jacobian(system, unknown), system)
        value = ca.vertcat(*start)
        for _ in range(NEWTON_STEPS):
            value = ca.substitute(moved, unknown, value)
        held = ca.vertsplit(ca.substitute(ca.vertcat(*load), unknown, value))
        return list(ca.vertsplit(value))[:n], {j: held[j] for j in sprung}

    @cached_property
    def full_signals(self) -> list[Signals]:
        """Signals of every joint with acceleration and the load that its friction goes with."""
        m = self.motion
        return [s.at(acceleration=m.motor[j], load=m.loading[j]) for j, s in enumerate(self.signals)]


def _row(matrix: Any, j: int, values: Sequence[Expression]) -> Expression:
    total: Expression = 0.0
    for i, value in enumerate(values):
        total = total + matrix[j, i] * value
    return total


def _masked(matrix: Any, free: list[Expression]) -> Any:
    """Return a mass matrix with the rows and columns of joints that are not free those of the unit matrix."""
    n, masked = len(free), ca.SX(*matrix.shape)
    for i in range(n):
        for j in range(n):
            masked[i, j] = free[i] * free[j] * matrix[i, j] + (1.0 - free[i] if i == j else 0.0)
    return masked


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
