"""The links of flexible joints one sample later: springs and faces that may be far stiffer than samples resolve."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import casadi as ca

from stribeck.model.balance import Balance
from stribeck.model.drive import Drive
from stribeck.model.sensitivity import Sensitivity

SUBSTEP = 1e-3  # s, longest step of a flexible joint's link
NEWTON = 3  # steps that find the force of a contact: its law has few pieces
INSIDE = 0.05  # of the way back from a face to where a step began that left it


def swing(
    balance: Balance, sample_time: float, now: Drive, after: Drive, carried: Sensitivity, ahead: Any
) -> Sensitivity:
    """Advance the links as deflections, motor less link: a stiff compliance takes little of the motion.

    What the arm asks of a link runs linearly from sample to sample; the compliance follows in finer steps. With
    contacts, the rates of the deflections come after the link states.

    Parameters
    ----------
    balance : Balance
    sample_time : float
        s.
    now, after : Drive
        At a sample, and at the next one.
    carried : Sensitivity
        States at the sample, the symbols of the path.
    ahead : casadi.SX (nx, 1)
        States foreseen for the next one.
    """
    path, x, p = balance.path, carried.states, balance.path.p
    links = 2 * len(path.flexible)
    later = balance.motors(after)
    start = balance.motors(now).deflections(x[:links])
    first, last = balance.links(now, x), balance.links(after, ca.vertcat(later.states(start), ahead[links:]))
    mobility, resistance = (0.5 * (getattr(first, what) + getattr(last, what)) for what in ("mobility", "resistance"))
    known = ca.vertcat(start, first.free, last.free, ca.vec(mobility), ca.vec(resistance))
    symbols = ca.SX.sym("known", known.numel())
    flexed = _flexed(balance, sample_time, symbols)
    slope = ca.Function("slope", [symbols, p], [flexed, ca.jacobian(flexed, symbols), ca.jacobian(flexed, p)])
    moved, by_known, by_own = slope(known, p)
    chosen = list(carried.parameters)
    through = ca.jacobian(known, p)[:, chosen] + ca.mtimes(ca.jacobian(known, x), carried.columns)
    along = ca.mtimes(by_known, through) + by_own[:, chosen]
    states, columns = later.states(moved), later.states(along, ca.jacobian(later.in_turn, p)[:, chosen])
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
    balance : Balance
    sample_time : float
        s.
    known : array (4 L + 3 L^2, 1)
        Deflections, rates, the links' free acceleration at both samples, their mobility, and the slopes of the torque
        from outside by their positions and velocities.
    """
    count = len(balance.path.flexible)
    deflection, rate, first, last = (known[i * count : (i + 1) * count] for i in range(4))
    mobility, resistance = known[4 * count : count * (4 + count)], known[count * (4 + count) :]
    mobility, resistance = ca.reshape(mobility, count, count), ca.reshape(resistance, count, 2 * count)
    h = sample_time / (steps := 1 if balance.contacts else max(1, round(sample_time / SUBSTEP)))
    newton = _newton(balance, h)
    setting = (known[: 2 * count], mobility, resistance, balance.path.p)
    ends = ca.DM([1.0 if face else 2.0 for face in balance.faces])  # a midpoint rule goes twice as far as its middle
    for i in range(steps):
        freely = first + (i + 0.5) / steps * (last - first)
        found = rate + h / ends * freely
        for _ in range(NEWTON if balance.contacts else 1):
            found = newton(found, deflection, rate, freely, *setting)
        deflection, rate = deflection + h * found, rate + ends * (found - rate)
    return ca.vertcat(deflection, rate)


def _newton(balance: Balance, h: float) -> ca.Function:
    """Return a better rate (L, 1) at the middle of a step of h, at its end where there are faces, from a guess.

    The others: deflection and rate where the step starts, free acceleration, both where the sample starts, mobility,
    slopes of the torque from outside, parameters.
    """
    count = len(balance.path.flexible)
    ahead = ca.DM([h if face else h / 2.0 for face in balance.faces])
    guess, start, began, free = (ca.SX.sym(name, count) for name in ("guess", "start", "began", "free"))
    sample, resistance = ca.SX.sym("sample", 2 * count), ca.SX.sym("resistance", count, 2 * count)
    mobile = ca.SX.sym("mobile", count, count)
    there = start + ahead * guess
    torque = balance.transmitted(there, guess)
    outside = ca.mtimes(resistance, ca.vertcat(there, guess) - sample)  # a link held back by as much as it lags
    missing = guess - began - ahead * (free - ca.mtimes(mobile, torque + outside))
    better = guess - ca.solve(ca.jacobian(missing, guess), missing)
    # a step off a face that presses goes no farther than its edge: from free flight the next would go back where it was
    edge = (balance.edges(torque) - start) / ahead
    left = ca.substitute(torque, guess, better) == 0.0
    faces = ca.DM([float(face) for face in balance.faces])
    better = ca.if_else(faces * (torque != 0.0) * left, edge + INSIDE * (guess - edge), better)
    return ca.Function("newton", [guess, start, began, free, sample, mobile, resistance, balance.path.p], [better])
