"""A stand that slides, one sample later: its spring may ring faster than samples resolve."""

from __future__ import annotations

from typing import Any

import casadi as ca

from stribeck.model.balance import Balance
from stribeck.model.drive import Drive
from stribeck.model.values import Expression

SUBSTEP = 1e-3  # s, longest step


def foreseen(balance: Balance, sample_time: float, now: Drive, x: Any) -> Any:
    """Return the states (nx, 1) with a stand's own where its present acceleration takes them in a sample."""
    rows = balance.path.stand_rows
    if not rows:
        return x
    ahead = ca.SX(x)
    acceleration = balance.derivatives(now, x)[rows[1]]
    ahead[rows[0]] = x[rows[0]] + sample_time * (x[rows[1]] + 0.5 * sample_time * acceleration)
    ahead[rows[1]] = x[rows[1]] + sample_time * acceleration
    return ahead


def slide(balance: Balance, sample_time: float, now: Drive, after: Drive, x: Any, ahead: Any) -> dict[str, Expression]:
    """Return a stand's states one sample later, by name; empty where there is none.

    What the arm's motion asks of it runs linearly from sample to sample, to the states foreseen; spring and damper
    follow by the implicit midpoint rule, in finer steps.

    Parameters
    ----------
    balance : Balance
    sample_time : float
        s.
    now, after : Drive
        At a sample, and at the next one.
    x : casadi.SX (nx, 1)
        States at the sample.
    ahead : casadi.SX (nx, 1)
        States foreseen for the next one.
    """
    path, rows = balance.path, balance.path.stand_rows
    if not rows:
        return {}
    k, effect = path.sliding  # type: ignore[misc]
    own = ca.SX.sym("own", 2)
    force = effect.force({"position": own[0], "velocity": own[1]}, path.parameters(k))
    pull = ca.Function("pull", [own, path.p], [force, ca.jacobian(force, own)])

    def asked(drive: Drive, states: Any) -> tuple[Expression, Expression]:
        whole = balance.stand(drive, states).mass  # type: ignore[union-attr]
        pulled = pull(ca.vertcat(*[states[i] for i in rows]), path.p)[0] / whole
        return balance.derivatives(drive, states)[rows[1]] - pulled, 1.0 / whole

    (first, mobility), (last, mobility_then) = asked(now, x), asked(after, ahead)
    mobile = 0.5 * (mobility + mobility_then)
    position, velocity = (x[i] for i in rows)
    steps = max(1, round(sample_time / SUBSTEP))
    half = 0.5 * sample_time / steps
    for i in range(steps):
        pulled, slope = (mobile * value for value in pull(ca.vertcat(position, velocity), path.p))
        given = pulled - slope[1] * velocity + first + (i + 0.5) / steps * (last - first)
        middle = (velocity + half * given) / (1.0 - half * half * slope[0] - half * slope[1])
        position, velocity = position + 2.0 * half * middle, 2.0 * middle - velocity
    return {path.state_names[rows[0]]: position, path.state_names[rows[1]]: velocity}
