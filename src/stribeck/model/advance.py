"""The states of a cut path one sample later.

The command runs linearly between the samples. So does the motion for all but a link, which a chord would mislead: a
stiff compliance turns the distance between chord and curve, h^2 / 8 of the acceleration at most, into torque.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca

from stribeck.model.balance import Balance
from stribeck.model.drive import DRIVE, Drive
from stribeck.model.effect import FrictionEffect
from stribeck.model.path import SignalPath
from stribeck.model.values import Expression

SUBSTEP = 1e-3  # s, longest step of a flexible joint's link
PASSED_ON = 2  # states of a chain that feel a change at its head within one step


def advance(balance: Balance, sample_time: float, now: Drive, after: Drive, carried: Sensitivity) -> Sensitivity:
    """Return the states (nx, 1) one sample later, and their sensitivities by some parameters.

    Parameters
    ----------
    balance : Balance
    sample_time : float
        Between the two drives, s.
    now, after : Drive
    carried : Sensitivity
        States now (the path's own symbols) and their sensitivities (nx, columns).
    """
    path, x = balance.path, carried.states
    mean = (after.position - now.position) / sample_time
    first, last = now.at(velocity=mean), after.at(velocity=mean)
    links = 2 * len(path.flexible)
    out: list[Expression] = []
    if len(path.state_names) > links:
        # a bristle follows the distance moved, the mean velocity's; other laws the velocity of the instant
        slid, moved = (_relax(balance, sample_time, *pair, x) for pair in ((first, last), (now, after)))
        bristles, known = _bristles(path), _slid(balance, sample_time, first, last, x)
        for i, name in enumerate(path.state_names[links:], links):
            out.append(known.get(name, slid[i]) if name in bristles else moved[i])
    rest = ca.vertcat(*out)
    through = ca.mtimes(ca.jacobian(rest, x), carried.columns)
    columns = through + ca.jacobian(rest, path.p)[:, list(carried.parameters)]
    if not links:
        return replace(carried, states=rest, columns=columns)
    swung = _swing(balance, sample_time, now, after, carried)
    return replace(carried, states=ca.vertcat(swung.states, rest), columns=ca.vertcat(swung.columns, columns))


@dataclass(frozen=True)
class Sensitivity:
    """States (nx, 1), the parameters that count, and the states' derivatives by them (nx, number of parameters)."""

    states: Any
    parameters: tuple[int, ...]
    columns: Any


def _bristles(path: SignalPath) -> frozenset[str]:
    """Return the names of the states that carry a joint's friction."""
    placed = [(k, place.effect) for k, place in enumerate(path.placed) if isinstance(place.effect, FrictionEffect)]
    return frozenset(f"{k}.{state}" for k, effect in placed if effect.bristle for state in effect.states)


def _slid(balance: Balance, sample_time: float, now: Drive, after: Drive, x: Any) -> dict[str, Expression]:
    """Return the bristle states whose law is known in closed form, by name."""
    path = balance.path
    out: dict[str, Expression] = {}
    for j in range(path.n):
        bristle = path.bristle(j)
        if bristle is None:
            continue
        k, effect = bristle
        s, later = balance.signals(now, x)[0][j], balance.signals(after, x)[0][j]
        level, distance = path.present_level(j, later, x), sample_time * s.velocity
        states = effect.bristle_moved(level, distance, path.states(k, x), path.parameters(k))
        out |= {f"{k}.{name}": value for name, value in (states or {}).items()}
    return out


def _swing(balance: Balance, sample_time: float, now: Drive, after: Drive, carried: Sensitivity) -> Sensitivity:
    """Advance the link states by the implicit midpoint rule: A-stable, second order.

    One Newton step solves it for a linear compliance, whose sensitivities come from the implicit function theorem; that
    spares the second derivatives of the arm. A contact needs two: with one, a step across its edge throws the link.
    There the solution may still be off, and the Newton steps themselves are differentiated.
    """
    path = balance.path
    links, h = 2 * len(path.flexible), sample_time / (steps := max(1, round(sample_time / SUBSTEP)))
    newton, slope = _midpoint(balance, h, carried.parameters)
    drive_rest = [carried.states[links:], path.p, balance.delay_at]
    contacts = _contacts(path)
    link, columns, rest = carried.states[:links], carried.columns[:links, :], carried.columns[links:, :]
    for i in range(steps):
        known = [_between(now, after, sample_time, (i + 0.5) / steps).stacked, *drive_rest]
        between = newton(link, link, *known)
        if contacts:
            first = slope(link, columns, link, columns, rest, *known)
            moved = slope(between, first, link, columns, rest, *known)
            between = newton(between, link, *known)
        else:
            moved = slope(between, columns, link, columns, rest, *known)
        link, columns = 2 * between - link, 2 * moved - columns
    return replace(carried, states=link, columns=columns)


def _between(now: Drive, after: Drive, sample_time: float, f: float) -> Drive:
    """Return the drive at a fraction ``f`` of the way to the next sample: positions on Hermite's cubic, others linear.

    The velocity is the cubic's. On the chord a motion at w is short by (w h)^2 / 12 of its amplitude, and a compliance
    with a natural frequency w0 then hands on (w0 h)^2 / 12 of the inertial torque too little, however slow the motion.
    """
    h, went = sample_time, after.position - now.position
    first, last = (1.0 - f) ** 2 * f, (1.0 - f) * f**2
    position = now.position + (3.0 - 2.0 * f) * f**2 * went + h * (first * now.velocity - last * after.velocity)
    ends = (1.0 - 4.0 * f + 3.0 * f**2) * now.velocity + (3.0 * f - 2.0) * f * after.velocity
    velocity = 6.0 * (1.0 - f) * f * went / h + ends
    stacked = now.stacked + f * (after.stacked - now.stacked)
    n = now.position.numel()
    return Drive(stacked[0], *[stacked[1 + i * n : 1 + (i + 1) * n] for i in range(len(DRIVE) - 1)]).at(
        position=position, velocity=velocity
    )


def _midpoint(balance: Balance, h: float, parameters: Sequence[int]) -> tuple[ca.Function, ca.Function]:
    """Return a Newton step for the links' states in the middle of a step of h, and the sensitivities that follow.

    The latter take the sensitivities of the state that the step starts from (used by a contact only), of the links at
    the start of h, and of the other states.
    """
    path = balance.path
    links, others = 2 * len(path.flexible), len(path.state_names) - 2 * len(path.flexible)
    middle, start, still = ca.SX.sym("middle", links), ca.SX.sym("start", links), ca.SX.sym("still", others)
    drive = Drive.symbols(path.n, "_mid")
    rate = balance.derivatives(drive, ca.vertcat(middle, still))[:links]
    matrix = ca.SX.eye(links) - h / 2 * ca.jacobian(rate, middle)
    known = [drive.stacked, still, path.p, balance.delay_at]
    correction = ca.solve(matrix, middle - start - h / 2 * rate)
    newton = ca.Function("newton", [middle, start, *known], [middle - correction])
    along = ca.SX.sym("along", links, len(parameters))
    before, rest = ca.SX.sym("before", links, len(parameters)), ca.SX.sym("rest", others, len(parameters))
    if _contacts(path):
        moved = middle - correction
        columns = ca.jacobian(moved, path.p)[:, list(parameters)]
        columns += ca.mtimes(ca.jacobian(moved, start), before) + ca.mtimes(ca.jacobian(moved, still), rest)
        columns += ca.mtimes(ca.jacobian(moved, middle), along)
    else:
        pushed = ca.jacobian(rate, path.p)[:, list(parameters)] + ca.mtimes(ca.jacobian(rate, still), rest)
        columns = ca.solve(matrix, ca.densify(before + h / 2 * pushed)) if parameters else before
    return newton, ca.Function("slope", [middle, along, start, before, rest, *known], [columns])


def _contacts(path: SignalPath) -> bool:
    """Tell whether a compliance's law is not linear in its deflection."""
    deflection, rate = ca.SX.sym("deflection"), ca.SX.sym("rate")
    both = ca.vertcat(deflection, rate)
    for j in path.flexible:
        k, effect = path.transmission(j)  # type: ignore[misc]
        torque = effect.transmitted(deflection, rate, path.parameters(k))
        if ca.depends_on(ca.jacobian(torque, both), both):
            return True
    return False


def _relax(balance: Balance, sample_time: float, now: Drive, after: Drive, x: Any) -> Any:
    """Advance each effect state by an exponential step, exact for a linear law under linear forcing.

    Where states drive one another, further rounds take the change of the others into account.
    """
    count = len(balance.path.state_names)
    state = ca.SX.sym("state", count)
    h = sample_time
    rate_now, rate_after = balance.derivatives(now, state), balance.derivatives(after, state)
    slopes = ca.jacobian(0.5 * (rate_now + rate_after), state)
    z = h * ca.diag(slopes)
    near = ca.fabs(z) < 1e-4
    safe = ca.if_else(near, 1.0, z)
    phi1 = ca.if_else(near, 1 + z / 2 + z**2 / 6, ca.expm1(safe) / safe)
    phi2 = ca.if_else(near, 0.5 + z / 6, (phi1 - 1) / safe)
    step = state + h * (phi1 * rate_now + phi2 * (rate_after - rate_now))
    slopes[:, : 2 * len(balance.path.flexible)] = 0.0  # links move by a step of their own
    coupling = ca.sparsify(slopes - ca.diag(ca.diag(slopes)))
    alone = step
    for _ in range(PASSED_ON if coupling.nnz() else 0):
        step = alone + h * phi2 * ca.mtimes(coupling, step - state)
    return ca.substitute(step, state, x)
