"""The path cut at the measured joint: recorded motion in, the torque that does not balance out.

Everything upstream of the cut is driven by the recorded command, everything downstream by the recorded motion.
States (a friction bristle, an actuator lag, a flexible joint's link) follow the same drive.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca

from stribeck.model.effect import ActuatorEffect, Expression, FrictionEffect, SensingEffect, Signals
from stribeck.model.path import SignalPath
from stribeck.model.rigid_body import inverse_dynamics, mass_matrix

RATES = ("position_rate", "velocity_rate", "acceleration_rate", "command_rate")
DRIVE = ("time", "position", "velocity", "acceleration", "command", *RATES, "velocity_sd")
SUBSTEP = 1e-3  # s, longest step of a flexible joint's link
UNSURE = 2.5  # standard deviations of velocity within which its sign, and so friction, is not known


@dataclass(frozen=True)
class Drive:
    """The recorded signals of all joints at one sample, each (n, 1) symbolic but ``time`` (1, 1).

    ``command`` is the command averaged over the sample before and after, as zero-order hold implies. The rates are
    time derivatives of signals that an effect delays, zero for others: those of the curves that are read off, from
    sample to sample, so that they differ a little from ``velocity`` and ``acceleration``. ``velocity_sd`` is the
    uncertainty of the velocity.
    """

    time: Any
    position: Any
    velocity: Any
    acceleration: Any
    command: Any
    position_rate: Any
    velocity_rate: Any
    acceleration_rate: Any
    command_rate: Any
    velocity_sd: Any

    @staticmethod
    def symbols(n: int, suffix: str = "") -> Drive:
        """Return fresh symbols."""
        return Drive(*[ca.SX.sym(f"{name}{suffix}", 1 if name == "time" else n) for name in DRIVE])

    @property
    def stacked(self) -> Any:
        """All signals, one column (1 + 9 n, 1)."""
        return ca.vertcat(*[getattr(self, name) for name in DRIVE])


class Cut:
    """Compiled cut of a signal path.

    Parameters
    ----------
    path : SignalPath
    sample_time : float
        Step of the uniform grid on which the states advance, s.
    columns : sequence of int or None
        Parameters whose derivatives are wanted; all where None.

    Attributes
    ----------
    active : tuple of int
        Parameters on which the states depend (columns that the sensitivity recursion carries).
    """

    def __init__(self, path: SignalPath, sample_time: float, columns: Sequence[int] | None = None) -> None:
        self.path, self.sample_time, self.n = path, sample_time, path.n
        self.columns = tuple(range(len(path.entries))) if columns is None else tuple(columns)
        self.delay_at = ca.SX.sym("T0", len(path.placed))
        self.drive = Drive.symbols(path.n)
        self.nx = path.x.numel()

    # --- the stages on one sample -------------------------------------------------------------------------

    def _command(self, d: Drive, joint: int) -> Expression:
        """Return the command, delayed. The data are delayed by T0 already; the rest is to first order."""
        command = d.command[joint]
        for k, effect in self.path.at(joint, ActuatorEffect):
            if effect.delays == "command":
                command = command - d.command_rate[joint] * (self.path.parameters(k)["time"] - self.delay_at[k])
        return command

    def _motion(self, d: Drive) -> list[Signals]:
        """Return the true signals of each joint on the motor side; the link's where it is rigid."""
        signals = []
        for j in range(self.n):
            y, dy, ddy = self._recorded(d, j)
            q, dq, ddq = self._true(j, y, dy, ddy)
            signals.append(Signals(d.time, q, dq, ddq, q, dq))
        return signals

    def _true(self, joint: int, y: Expression, dy: Expression, ddy: Expression) -> tuple[Expression, ...]:
        """Return true position, velocity and acceleration from what the sensor gave."""
        if not self.path.at(joint, SensingEffect):
            return y, dy, ddy
        seen = ca.SX.sym("seen")
        law = self.path.true_position(joint, seen)
        slope = ca.jacobian(law, seen)
        q, slope, curve = ca.substitute([law, slope, ca.jacobian(slope, seen)], [seen], [ca.SX(y)])
        return q, slope * dy, slope * ddy + curve * dy**2

    def _recorded(self, d: Drive, joint: int) -> tuple[Expression, Expression, Expression]:
        """Return position, velocity and acceleration as the sensor gave them, the lateness of the record undone."""
        y, dy, ddy = d.position[joint], d.velocity[joint], d.acceleration[joint]
        for k, effect in self.path.at(joint, SensingEffect):
            if effect.delays == "position":  # the data are moved by T0 already; the rest is to first order
                ahead = self.path.parameters(k)["time"] - self.delay_at[k]
                y, dy = y + d.position_rate[joint] * ahead, dy + d.velocity_rate[joint] * ahead
                ddy = ddy + d.acceleration_rate[joint] * ahead
        return y, dy, ddy

    def signals(self, d: Drive, x: Any) -> tuple[list[Signals], dict[int, Expression]]:
        """Return the signals of every joint, load included, and the link accelerations of flexible joints."""
        path, motion = self.path, self._motion(d)
        transmitted: dict[int, Expression] = {}
        for j in path.flexible:
            k, effect = path.transmission(j)  # type: ignore[misc]
            ql, dql = x[path.state_index(f"link[{j}].position")], x[path.state_index(f"link[{j}].velocity")]
            s = motion[j]
            transmitted[j] = effect.transmitted(s.position - ql, s.velocity - dql, path.parameters(k))
            motion[j] = s.at(link_position=ql, link_velocity=dql)
        load, acceleration = self._link_torques(motion, x, transmitted)
        full = [s.at(load=load[j]) for j, s in enumerate(motion)]
        full = [s.at(torque=path.actuated(j, self._command(d, j), s, x)) for j, s in enumerate(full)]
        return full, acceleration

    def _link_torques(
        self, motion: list[Signals], x: Any, transmitted: dict[int, Expression]
    ) -> tuple[list[Expression], dict[int, Expression]]:
        path, body = self.path, self.path.body()
        q, dq = [s.link_position for s in motion], [s.link_velocity for s in motion]
        external = [path.external(j, s, x) for j, s in enumerate(motion)]
        known = [0.0 if j in transmitted else s.acceleration for j, s in enumerate(motion)]
        bias = inverse_dynamics(body, q, dq, known, prismatic=path.prismatic)
        load = [bias[j] + external[j] for j in range(self.n)]
        if not transmitted:
            return load, {}
        flexible = list(path.flexible)
        mass = mass_matrix(body, q, prismatic=path.prismatic)
        # what carries the motor moves by the link's motion less the motor's, and takes its share of the torque
        carried = {j: 0.0 if (inertia := path.carrier(j)) is None else inertia for j in flexible}
        pushed = [transmitted[j] - load[j] + carried[j] * motion[j].acceleration for j in flexible]
        inertia = mass[flexible, flexible] + ca.diag(ca.vertcat(*carried.values()))
        swing = ca.solve(inertia, ca.vertcat(*pushed))
        for j in range(self.n):
            if j in transmitted:
                load[j] = transmitted[j] - carried[j] * (swing[flexible.index(j)] - motion[j].acceleration)
            else:
                load[j] = load[j] + ca.mtimes(mass[j, flexible], swing)
        return load, {j: swing[i] for i, j in enumerate(flexible)}

    def _friction(self, joint: int, s: Signals, d: Drive, x: Any, needed: Expression) -> Expression:
        """Return friction without its viscous part, given the torque ``needed`` to balance the joint.

        At rest friction is an interval, not a value; so it is wherever noise hides the sign of the velocity.
        """
        path = self.path
        bristle = path.bristle(joint)
        if bristle is not None:
            k, effect = bristle
            level = self._moving_level(joint, s, x)
            return effect.bristle_torque(level, s, path.states(k, x), path.parameters(k))
        speed = ca.fabs(s.velocity)
        forward, backward = (path.level(joint, speed, way, s, x) for way in (1.0, -1.0))
        z = s.velocity / d.velocity_sd[joint]
        lowest, highest = (ca.erf((z + side * UNSURE) / ca.sqrt(2.0)) for side in (-1.0, 1.0))
        lower, upper = (ca.fmax(way, 0.0) * forward + ca.fmin(way, 0.0) * backward for way in (lowest, highest))
        return ca.fmin(ca.fmax(needed, lower), upper)

    def _moving_level(self, joint: int, s: Signals, x: Any) -> Expression:
        speed = ca.fabs(s.velocity)
        forward, backward = (self.path.level(joint, speed, way, s, x) for way in (1.0, -1.0))
        return ca.if_else(s.velocity >= 0, forward, backward)

    def residual(self, d: Drive, x: Any) -> tuple[Any, dict[str, Any]]:
        """Return the unbalanced torque (n, 1) in units of the command, and the torques of each stage (n, 1)."""
        path = self.path
        signals, _ = self.signals(d, x)
        rows, stages = [], []
        for j, s in enumerate(signals):
            rotor = path.rotor(j) * s.acceleration
            needed = s.torque - rotor - s.load
            viscous = path.viscous(j, s, x)
            friction = self._friction(j, s, d, x, needed - viscous) + viscous
            scale = path.command_scale(j)
            rows.append((needed - friction) / scale)
            stages.append((s.torque / scale, rotor / scale, s.load / scale, friction / scale))
        names = ("actuator", "rotor", "load", "friction")
        return ca.vertcat(*rows), {name: ca.vertcat(*[s[i] for s in stages]) for i, name in enumerate(names)}

    # --- states -------------------------------------------------------------------------------------------

    def derivatives(self, d: Drive, x: Any) -> Any:
        """Return the time derivative (nx, 1) of the states under the drive."""
        path = self.path
        signals, acceleration = self.signals(d, x)
        out: list[Expression] = []
        for j in path.flexible:
            out += [signals[j].link_velocity, acceleration[j]]
        for k, place in enumerate(path.placed):
            effect, s, p = place.effect, signals[place.joint], path.parameters(k)
            if isinstance(effect, FrictionEffect) and effect.bristle:
                level = self._moving_level(place.joint, s, x)
                rates = effect.bristle_derivatives(level, s, path.states(k, x), p)
            elif effect.states:
                upstream = s.at(torque=self._upstream(k, d, s, x))
                rates = effect.derivatives(upstream, path.states(k, x), p)
            else:
                continue
            out += [rates[name] for name in effect.states]
        return ca.vertcat(*out)

    def _upstream(self, k: int, d: Drive, s: Signals, x: Any) -> Expression:
        """Return the torque that enters the k-th effect: the actuator's output for all but actuator effects."""
        place = self.path.placed[k]
        if not isinstance(place.effect, ActuatorEffect):
            return s.torque
        torque = self._command(d, place.joint)
        for other, effect in self.path.at(place.joint, ActuatorEffect):
            if other == k:
                break
            torque = effect.torque(torque, s, self.path.states(other, x), self.path.parameters(other))
        return torque

    def start(self, d: Drive) -> Any:
        """Return the states (nx, 1) with which a recording starts."""
        path = self.path
        motion = self._motion(d)
        body = path.body()
        still = [0.0] * self.n
        static = inverse_dynamics(body, [s.position for s in motion], still, still, prismatic=path.prismatic)
        out: list[Expression] = []
        for j in path.flexible:
            k, effect = path.transmission(j)  # type: ignore[misc]
            out += [motion[j].position - effect.deflection(static[j], path.parameters(k)), motion[j].velocity]
        for k, place in enumerate(path.placed):
            s = motion[place.joint].at(torque=self._command(d, place.joint))
            values = place.effect.initial(s, path.parameters(k))
            out += [values[name] for name in place.effect.states]
        return ca.vertcat(*out)

    def advance(self, now: Drive, after: Drive, x: Any) -> Any:
        """Return the states one sample later; motion and command run linearly between the samples."""
        mean = (after.position - now.position) / self.sample_time
        first, last = _with(now, velocity=mean), _with(after, velocity=mean)
        links = 2 * len(self.path.flexible)
        out = [self._swing(first, last, x, links)] if links else []
        if self.nx > links:
            # a bristle follows the distance moved, the mean velocity's; other laws the velocity of the instant
            slid, moved = self._relax(first, last, x), self._relax(now, after, x)
            out += [slid[i] if self.path.state_names[i] in self._bristles else moved[i] for i in range(links, self.nx)]
        return ca.vertcat(*out)

    @cached_property
    def _bristles(self) -> frozenset[str]:
        """Names of the states that carry a joint's friction."""
        placed = enumerate(self.path.placed)
        kinds = [(k, place.effect) for k, place in placed if isinstance(place.effect, FrictionEffect)]
        return frozenset(f"{k}.{state}" for k, effect in kinds if effect.bristle for state in effect.states)

    def _swing(self, now: Drive, after: Drive, x: Any, links: int) -> Any:
        """Advance the link states by the implicit midpoint rule: A-stable, second order.

        One Newton step solves it for a linear compliance. A contact needs two: with one, a step across its edge
        throws the link, and the sensitivities grow without bound.
        """
        steps = max(1, round(self.sample_time / SUBSTEP))
        h = self.sample_time / steps
        middle, start, drive = ca.SX.sym("middle", links), ca.SX.sym("start", links), Drive.symbols(self.n, "_mid")
        rate = self.derivatives(drive, ca.vertcat(middle, x[links:]))[:links]
        slope = ca.jacobian(rate, middle)
        correction = ca.solve(ca.SX.eye(links) - h / 2 * slope, middle - start - h / 2 * rate)
        known = [drive.stacked, x[links:], self.path.p, self.delay_at]
        newton = ca.Function("newton", [middle, start, *known], [middle - correction])
        link = x[:links]
        for i in range(steps):
            f = (i + 0.5) / steps
            known[0] = now.stacked + f * (after.stacked - now.stacked)
            between = newton(link, link, *known)
            if self._contacts:
                between = newton(between, link, *known)
            link = 2 * between - link
        return link

    @property
    def _contacts(self) -> bool:
        """Whether a compliance's law is not linear in its deflection."""
        deflection, rate = ca.SX.sym("deflection"), ca.SX.sym("rate")
        both = ca.vertcat(deflection, rate)
        for j in self.path.flexible:
            k, effect = self.path.transmission(j)  # type: ignore[misc]
            torque = effect.transmitted(deflection, rate, self.path.parameters(k))
            if ca.depends_on(ca.jacobian(torque, both), both):
                return True
        return False

    def _relax(self, now: Drive, after: Drive, x: Any) -> Any:
        """Advance each effect state by an exponential step, exact for a linear law under linear forcing."""
        state = ca.SX.sym("state", self.nx)
        h = self.sample_time
        rate_now, rate_after = self.derivatives(now, state), self.derivatives(after, state)
        middle = 0.5 * (rate_now + rate_after)
        slope = ca.vertcat(*[ca.jacobian(middle[i], state[i]) for i in range(self.nx)])
        z = h * slope
        near = ca.fabs(z) < 1e-4
        safe = ca.if_else(near, 1.0, z)
        phi1 = ca.if_else(near, 1 + z / 2 + z**2 / 6, ca.expm1(safe) / safe)
        phi2 = ca.if_else(near, 0.5 + z / 6, (phi1 - 1) / safe)
        step = state + h * (phi1 * rate_now + phi2 * (rate_after - rate_now))
        return ca.substitute(step, state, x)

    # --- compiled -----------------------------------------------------------------------------------------

    @cached_property
    def active(self) -> tuple[int, ...]:
        """Parameters on which the states depend."""
        if self.nx == 0:
            return ()
        after = Drive.symbols(self.n, "1")
        depends = ca.vertcat(self.advance(self.drive, after, self.path.x), self.start(self.drive))
        rows = ca.jacobian(depends, self.path.p).sparsity()
        return tuple(sorted({int(c) for c in rows.get_triplet()[1]} & set(self.columns)))

    @cached_property
    def begin(self) -> ca.Function:
        """(drive, p, T0) -> states and their sensitivities, stacked (nx (1 + active), 1)."""
        start = self.start(self.drive)
        sensitivity = ca.jacobian(start, self.path.p)[:, list(self.active)]
        return ca.Function(
            "begin",
            [self.drive.stacked, self.path.p, self.delay_at],
            [ca.densify(ca.vertcat(start, ca.vec(sensitivity)))],
        )

    @cached_property
    def follow(self) -> ca.Function:
        """(states, drive now, drive one sample later, p, T0) -> states and sensitivities one sample later."""
        after = Drive.symbols(self.n, "1")
        moved = self.advance(self.drive, after, self.path.x)
        carried = ca.SX.sym("S", self.nx, len(self.active))
        through = ca.mtimes(ca.jacobian(moved, self.path.x), carried)
        sensitivity = through + ca.jacobian(moved, self.path.p)[:, list(self.active)]
        state = ca.vertcat(self.path.x, ca.vec(carried))
        return ca.Function(
            "follow",
            [state, self.drive.stacked, after.stacked, self.path.p, self.delay_at],
            [ca.densify(ca.vertcat(moved, ca.vec(sensitivity)))],
        )

    @cached_property
    def evaluate(self) -> ca.Function:
        """(drive, states, p, T0) -> residual (n, 1) and its Jacobian by the wanted columns, stacked."""
        carried = ca.SX.sym("S", self.nx, len(self.active))
        residual, _ = self.residual(self.drive, self.path.x)
        jacobian = ca.SX(ca.densify(ca.jacobian(residual, self.path.p)[:, list(self.columns)]))
        if self.nx:
            place = [self.columns.index(i) for i in self.active]
            jacobian[:, place] += ca.mtimes(ca.jacobian(residual, self.path.x), carried)
        state = ca.vertcat(self.path.x, ca.vec(carried))
        inputs = [self.drive.stacked, state, self.path.p, self.delay_at]
        return ca.Function("evaluate", inputs, [ca.densify(ca.vertcat(residual, ca.vec(jacobian)))])

    @cached_property
    def balance(self) -> ca.Function:
        """(drive, states, p, T0) -> residual (n, 1) and the stages' torques stacked (4 n, 1)."""
        carried = ca.SX.sym("S", self.nx, len(self.active))
        residual, stages = self.residual(self.drive, self.path.x)
        state = ca.vertcat(self.path.x, ca.vec(carried))
        inputs = [self.drive.stacked, state, self.path.p, self.delay_at]
        return ca.Function("balance", inputs, [ca.densify(residual), ca.densify(ca.vertcat(*stages.values()))])


def _with(drive: Drive, **changes: Any) -> Drive:
    return Drive(**{name: changes.get(name, getattr(drive, name)) for name in DRIVE})
