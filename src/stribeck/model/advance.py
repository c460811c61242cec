"""The states of a cut path one sample later.

The command and the motion run linearly between the samples.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import casadi as ca

from stribeck.model.balance import Balance
from stribeck.model.drive import Drive
from stribeck.model.effect import FrictionEffect
from stribeck.model.path import SignalPath
from stribeck.model.values import Expression

SUBSTEP = 1e-3  # s, longest step of a flexible joint's link
NEWTON = 2  # steps that find the force of a contact: its law has few pieces
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
        own = x[: len(path.state_names)]
        slid, moved = (_relax(balance, sample_time, *pair, own) for pair in ((first, last), (now, after)))
        bristles, known = _bristles(path), _slid(balance, sample_time, first, last, x)
        for i, name in enumerate(path.state_names[links:], links):
            out.append(known.get(name, slid[i]) if name in bristles else moved[i])
    rest = ca.vertcat(*out)
    through = ca.mtimes(ca.jacobian(rest, x), carried.columns)
    columns = through + ca.jacobian(rest, path.p)[:, list(carried.parameters)]
    if not links:
        return replace(carried, states=rest, columns=columns)
    swung = _swing(balance, sample_time, now, after, carried)
    parts = [
        (swung.states[:links], rest, swung.states[links:]),
        (swung.columns[:links, :], columns, swung.columns[links:, :]),
    ]
    states, columns = (ca.vertcat(*part) for part in parts)
    return replace(carried, states=states, columns=columns)


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
    """Advance the links as deflections, motor less link: a stiff compliance takes little of the motion.

    What the arm asks of a link runs linearly from sample to sample; the compliance follows in finer steps. With
    contacts, the rates of the deflections come after the link states.
    """
    path, x, p = balance.path, carried.states, balance.path.p
    links = 2 * len(path.flexible)
    first = balance.links(now, x)
    start = first.deflections(x[:links])
    last = balance.links(after, x)  # the motors' own motion only
    last = balance.links(after, ca.vertcat(last.states(start), x[links:]))
    mobility = 0.5 * (first.mobility + last.mobility)
    known = ca.vertcat(start, first.free, last.free, ca.vec(mobility))
    symbols = ca.SX.sym("known", known.numel())
    flexed = _flexed(balance, sample_time, symbols)
    slope = ca.Function("slope", [symbols, p], [flexed, ca.jacobian(flexed, symbols), ca.jacobian(flexed, p)])
    moved, by_known, by_own = slope(known, p)
    chosen = list(carried.parameters)
    through = ca.jacobian(known, p)[:, chosen] + ca.mtimes(ca.jacobian(known, x), carried.columns)
    along = ca.mtimes(by_known, through) + by_own[:, chosen]
    states, columns = last.states(moved), last.states(along, ca.jacobian(last.motors, p)[:, chosen])
    if balance.contacts:
        half = links // 2
        states, columns = ca.vertcat(states, moved[half:]), ca.vertcat(columns, along[half:, :])
    return replace(carried, states=states, columns=columns)


def _flexed(balance: Balance, sample_time: float, known: Any) -> Any:
    """Return deflections and their rates (2 L, 1) one sample later.

    Linear compliances go by the implicit midpoint rule (A-stable, second order), solved by one Newton step. A contact
    goes by one implicit Euler step (Moreau 1988): faces too stiff for the samples then meet without a bounce and stay
    together.

    Parameters
    ----------
    known : array (4 L + L^2, 1)
        Deflections, rates, the links' free acceleration at both samples, their mobility.
    """
    path, contacts = balance.path, balance.contacts
    count = len(path.flexible)
    deflection, rate, first, last = (known[i * count : (i + 1) * count] for i in range(4))
    mobility = ca.reshape(known[4 * count :], count, count)
    h = sample_time / (steps := 1 if contacts else max(1, round(sample_time / SUBSTEP)))
    ahead = h if contacts else h / 2.0  # where in a step its forces are those of the step
    start, began, free = (ca.SX.sym(name, count) for name in ("start", "began", "free"))
    mobile, own, guess = ca.SX.sym("mobile", count, count), ca.SX.sym("own", path.p.numel()), ca.SX.sym("guess", count)
    torque = ca.substitute(balance.transmitted(start + ahead * guess, guess), path.p, own)
    missing = guess - began - ahead * (free - ca.mtimes(mobile, torque))
    better = guess - ca.solve(ca.jacobian(missing, guess), missing)
    newton = ca.Function("newton", [guess, start, began, free, mobile, own], [better])
    for i in range(steps):
        freely = first + (i + 0.5) / steps * (last - first)
        found = rate + ahead * freely
        for _ in range(NEWTON if contacts else 1):
            found = newton(found, deflection, rate, freely, mobility, path.p)
        deflection, rate = deflection + h * found, found if contacts else 2.0 * found - rate
    return ca.vertcat(deflection, rate)


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
