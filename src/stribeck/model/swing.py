"""The links of flexible joints one sample later: springs and faces that may be far stiffer than samples resolve."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import casadi as ca

from stribeck.model.balance import Balance
from stribeck.model.drive import Drive
from stribeck.model.sensitivity import Sensitivity

SUBSTEP = 1e-3  # s, longest step of a flexible joint's link
NEWTON = 2  # steps that find the force of a contact: its law has few pieces


def swing(balance: Balance, sample_time: float, now: Drive, after: Drive, carried: Sensitivity) -> Sensitivity:
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
