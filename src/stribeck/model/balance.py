"""The balance at the measured joint at one sample: what lies before it driven by the command, behind it by the motion.

Everything upstream of the cut is driven by the recorded command, everything downstream by the recorded motion.
"""

from __future__ import annotations

from typing import Any

import casadi as ca

from stribeck.model.asked import asked_once
from stribeck.model.drive import Drive
from stribeck.model.effect import Along, FrictionEffect
from stribeck.model.links import Links, Motors
from stribeck.model.path import SignalPath
from stribeck.model.rigid_body import inverse_dynamics, mass_matrix
from stribeck.model.stand import Stand
from stribeck.model.told import Told
from stribeck.model.values import Expression, Signals

HARDLY_ANY = 1e-12  # N m
UNSURE = 3.5  # standard deviations of velocity up to which its sign, and so friction, is not known
FADING = 0.5  # of them, over which it becomes sure


def _ahead(sds: Expression) -> Expression:
    """Return the chance of going forward at a speed of so many standard deviations; it fades in over FADING of them."""
    return 0.5 * (1.0 + ca.erf(sds / FADING / ca.sqrt(2.0)))


class Balance:
    """Torques of a signal path at one sample of recorded motion, and the rates of its states.

    Parameters
    ----------
    path : SignalPath

    Attributes
    ----------
    delay_at : casadi.SX (placed, 1)
        Delays by which the drive was moved already, s: the rest of a delay is taken to first order.
    faces : tuple of bool
        Of each flexible joint, whether its link meets its motor at faces. ``contacts``: whether any does.
    x : casadi.SX (nx, 1)
        The path's states; with contacts, then how much faster each flexible joint's motor is than its link, rad/s; then
        how far the recorded motion has bent each of the ``bristled`` joints' bristles, N m.
    bristled : tuple of int
        Joints with a bristle that is damped in the mean from sample to sample.
    """

    def __init__(self, path: SignalPath) -> None:
        self.path, self.n = path, path.n
        self._told = Told(path)
        self.delay_at = self._told.delay_at
        count = len(path.flexible)
        both = ca.SX.sym("both", 2 * count)
        torque = self.transmitted(both[:count], both[count:])
        self.faces = tuple(bool(ca.depends_on(ca.jacobian(torque[i], both), both)) for i in range(count))
        self.contacts = any(self.faces)
        bristles = {j: found for j in range(path.n) if (found := path.bristle(j)) is not None}
        self.bristled = tuple(j for j, found in bristles.items() if self._mean_torque(*found, 0.0, path.x) is not None)
        ahead = ca.SX.sym("ahead", len(path.flexible) if self.contacts else 0)
        self._settled = path.x.numel(), path.x.numel() + ahead.numel()
        self.x = ca.vertcat(path.x, ahead, ca.SX.sym("bent", len(self.bristled)))

    def _mean_torque(self, k: int, effect: FrictionEffect, rate: Any, x: Any) -> Expression | None:
        return effect.bristle_mean_torque(rate, self.path.states(k, x), self.path.parameters(k))

    def transmitted(self, deflection: Any, rate: Any) -> Any:
        """Return what the L flexible joints hand on (L, 1) at their deflections and rates (L, 1)."""
        torques = []
        for i, j in enumerate(self.path.flexible):
            k, effect = self.path.transmission(j)  # type: ignore[misc]
            torques.append(effect.transmitted(deflection[i], rate[i], self.path.parameters(k)))
        return ca.vertcat(*torques)

    def edges(self, towards: Any) -> Any:
        """Return the deflections (L, 1) at which a torque ``towards`` either side begins."""
        angles = []
        for i, j in enumerate(self.path.flexible):
            k, effect = self.path.transmission(j)  # type: ignore[misc]
            angles.append(effect.deflection(HARDLY_ANY * ca.sign(towards[i]), self.path.parameters(k)))
        return ca.vertcat(*angles)

    @asked_once
    def signals(self, d: Drive, x: Any, slowing: Any | None = None) -> tuple[list[Signals], dict[int, Expression]]:
        """Return the signals of every joint, load included, and the link accelerations of flexible joints.

        Where the links' ``slowing`` (L, 1) against their motors is given, rad/s^2, it tells the load.
        """
        path, motion = self.path, self._with_links(self._told.motion(d), x)
        load, mass, inertia, carried = self._unmoved(motion, x)
        swing = ca.SX(0, 1)
        if path.flexible:
            s = [motion[j] for j in path.flexible]
            own = ca.vertcat(*[one.acceleration for one in s])
            if slowing is None:
                deflection = ca.vertcat(*[one.position - one.link_position for one in s])
                rate = ca.vertcat(*[one.velocity - one.link_velocity for one in s])
                # what carries the motor moves by the link's motion less the motor's, and takes its share of the torque
                loads = ca.vertcat(*[load[j] for j in path.flexible])
                swing = ca.solve(inertia, self.transmitted(deflection, rate) - loads + carried * own)
            else:
                swing = own - slowing
            load = [load[j] + ca.mtimes(mass[j, list(path.flexible)], swing) for j in range(self.n)]
        full = [s.at(load=load[j]) for j, s in enumerate(path.weighed(motion, x, level=True))]
        full = [s.at(torque=path.actuated(j, self._told.command(d, j), s, x)) for j, s in enumerate(full)]
        return full, {j: swing[i] for i, j in enumerate(path.flexible)}

    def _with_links(self, motion: list[Signals], x: Any) -> list[Signals]:
        """Return the signals with the links of flexible joints where their states say."""
        motion = list(motion)
        for j in self.path.flexible:
            ql, dql = (x[self.path.state_index(f"link[{j}].{what}")] for what in ("position", "velocity"))
            motion[j] = motion[j].at(link_position=ql, link_velocity=dql)
        return motion

    def motors(self, d: Drive) -> Motors:
        """Return where the motors of the flexible joints are, and how fast."""
        motion = self._told.motion(d)
        here = [motion[j] for j in self.path.flexible]
        return Motors(ca.vertcat(*[s.position for s in here]), ca.vertcat(*[s.velocity for s in here]))

    @asked_once
    def links(self, d: Drive, x: Any) -> Links:
        """Return what moves the links of the flexible joints."""
        flexible = list(self.path.flexible)
        motion = self._with_links(self._told.motion(d), x)
        load, _, inertia, carried = self._unmoved(motion, x)
        acceleration = ca.vertcat(*[motion[j].acceleration for j in flexible])
        loads = ca.vertcat(*[load[j] for j in flexible])
        mobility = ca.inv(inertia)
        free = acceleration - ca.mtimes(mobility, carried * acceleration - loads)
        return Links(free, mobility, self._resistance(motion, x))

    def stand(self, d: Drive, x: Any) -> Stand | None:
        """Return the stand that slides under the arm, if there is one."""
        return self.path.stand(self._with_links(self._told.motion(d), x), x, level=True)

    def _resistance(self, motion: list[Signals], x: Any) -> Any:
        """Return the slopes (L, 2 L) of the torque from outside by the links' positions, then by their velocities."""
        flexible = self.path.flexible
        at, moved = ca.SX.sym("at", 2 * len(flexible)), list(motion)
        for i, j in enumerate(flexible):
            moved[j] = moved[j].at(link_position=at[i], link_velocity=at[len(flexible) + i])
        torques = self.path.external(moved, x)
        slopes = ca.jacobian(ca.SX(ca.vertcat(*[torques[j] for j in flexible])), at)
        here = [getattr(motion[j], name) for name in ("link_position", "link_velocity") for j in flexible]
        return ca.densify(ca.substitute(slopes, at, ca.vertcat(*here)))

    def _unmoved(self, motion: list[Signals], x: Any) -> tuple[list[Expression], Any, Any, Any]:
        """Return the loads with the links of flexible joints unaccelerated, the mass matrix, inertia and carriers.

        The last two are of the flexible joints: what their torque accelerates, and what of it carries the motor.
        """
        path, body = self.path, self.path.body
        q, dq = path.angles(motion, x, level=True)
        external = path.external(motion, x)
        known = [0.0 if j in path.flexible else s.acceleration for j, s in enumerate(motion)]
        bias = inverse_dynamics(body, q, dq, known, prismatic=path.prismatic)
        load = [bias[j] + external[j] for j in range(self.n)]
        stand = path.stand(motion, x, level=True)
        if stand is not None:
            load = stand.loads(load, known)
        flexible = list(path.flexible)
        if not flexible:
            return load, None, None, None
        mass = mass_matrix(body, q, prismatic=path.prismatic)
        if stand is not None:
            mass = stand.inertia(mass)
        carried = ca.vertcat(*[0.0 if (inertia := path.carrier(j)) is None else inertia for j in flexible])
        return load, mass, mass[flexible, flexible] + ca.diag(carried), carried

    def _friction(
        self, joint: int, s: Signals, d: Drive, x: Any, needed: Expression, bending: Expression | None
    ) -> Expression:
        """Return friction without its viscous part, given the torque ``needed`` to balance the joint.

        A bristle is damped at its mean rate of ``bending`` about the sample, N m/s, where that is known.

        At rest friction is an interval, not a value; so it is wherever noise hides the sign of the velocity, and where
        that changes within the sample. Where the joint surely rests, the speed is noise and what the filter brings of
        the motion beside: it must not lower the level, or a fit raises Stribeck's constant to make up for it. Nor must
        the flutter of the accelerations take what is needed beyond the level: it would do so on one side only, where
        the joint is held near its level, and no filter takes that out again.
        """
        path = self.path
        bristle = path.bristle(joint)
        if bristle is not None:
            k, effect = bristle
            if bending is not None and (mean := self._mean_torque(k, effect, bending, x)) is not None:
                return mean
            level = path.present_level(joint, s, x)
            return effect.bristle_torque(level, s, path.states(k, x), path.parameters(k))
        sd, reach = d.velocity_sd[joint], d.instant[joint] * ca.fabs(s.acceleration)
        low, high = (_ahead((s.velocity + side * reach) / sd + side * UNSURE) for side in (-1.0, 1.0))
        speed = (1.0 - d.resting[joint]) * ca.fabs(s.velocity)
        forward, backward = (path.level(joint, speed, way, s, x) for way in (1.0, -1.0))
        lower, upper = (ahead * forward - (1.0 - ahead) * backward for ahead in (low, high))
        told, flutter = (
            ca.vertcat(*[getattr(d, name + rate) for rate in ("", "_rate")]) for name in ("acceleration", "flutter")
        )
        quick = ca.jtimes(needed, told, flutter)
        return ca.fmin(ca.fmax(needed - quick, lower), upper) + (high - low) * quick

    @asked_once
    def residual(self, d: Drive, x: Any, *, settled: bool = True) -> tuple[Any, dict[str, Any]]:
        """Return the unbalanced torque (n, 1) in units of the command, and the torques of each stage (n, 1).

        What follows the path's states in ``x`` are the rates of :meth:`stribeck.model.cut.Cut.settled`, rad/s^2 and
        N m/s, unless they are not ``settled`` yet.
        """
        path = self.path
        begin, end = self._settled
        signals, _ = self.signals(d, x, x[begin:end] if self.contacts and settled else None)
        bending = {j: x[end + i] for i, j in enumerate(self.bristled)} if settled else {}
        rows, stages = [], []
        for j, s in enumerate(signals):
            rotor = path.rotor(j) * s.acceleration
            needed = s.torque - rotor - s.load
            viscous = path.viscous(j, s, x)
            friction = self._friction(j, s, d, x, needed - viscous, bending.get(j)) + viscous
            scale = path.command_scale(j, s.position)
            rows.append((needed - friction) / (scale * path.torque_left(j, s, x)))
            stages.append((s.torque / scale, rotor / scale, s.load / scale, friction / scale))
        names = ("actuator", "rotor", "load", "friction")
        return ca.vertcat(*rows), {name: ca.vertcat(*[s[i] for s in stages]) for i, name in enumerate(names)}

    def derivatives(self, d: Drive, x: Any) -> Any:
        """Return the time derivative (nx, 1) of the states under the drive."""
        signals, acceleration = self.signals(d, x)
        out: list[Expression] = []
        for j in self.path.flexible:
            out += [signals[j].link_velocity, acceleration[j]]
        links = [acceleration.get(j, s.acceleration) for j, s in enumerate(signals)]
        for k, place in enumerate(self.path.placed):
            out += self.path.rates(k, self._told.command(d, place.joint), signals, links, x, level=True)
        return ca.vertcat(*out)

    def start(self, d: Drive) -> Any:
        """Return the states (nx, 1) with which a recording starts."""
        path = self.path
        motion = self._told.motion(d)
        body = path.body
        still = [0.0] * self.n
        static = inverse_dynamics(body, [s.position for s in motion], still, still, prismatic=path.prismatic)
        resting = [s.at(velocity=0.0, link_velocity=0.0) for s in motion]
        outside, resistance = path.external(resting, path.x), self._resistance(resting, path.x)
        out = ca.SX.zeros(path.x.numel())
        for i, j in enumerate(path.flexible):
            k, effect = path.transmission(j)  # type: ignore[misc]
            torque = ca.SX.sym("torque")
            bent = effect.deflection(torque, path.parameters(k))
            # a spring or a wall pushes less on a link that gives way: a step of Newton's method
            less = resistance[i, i] * bent / (1.0 + resistance[i, i] * ca.jacobian(bent, torque))
            pulled = static[j] + outside[j]
            held = pulled - ca.substitute(less, torque, pulled)
            held = ca.if_else(pulled * held > 0.0, held, 0.0)  # else it lies in its play
            at = motion[j].position - ca.substitute(bent, torque, held)
            out[2 * i], out[2 * i + 1] = at, motion[j].velocity
        weighed = path.weighed(motion, out, level=True)
        # a lag starts at what the stages before it leave of the command
        for k, place in sorted(enumerate(path.placed), key=lambda one: getattr(one[1].effect, "along", len(Along))):
            s = weighed[place.joint].at(load=static[place.joint])
            s = s.at(torque=path.entering(k, self._told.command(d, place.joint), s, out))
            values = place.effect.initial(path.rubbed(k, s, out), path.parameters(k))
            for name in place.effect.states:
                out[path.state_index(f"{k}.{name}")] = values[name]
        return out
