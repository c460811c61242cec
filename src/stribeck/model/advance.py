"""The states of a cut path one sample later.

The command and the motion run linearly between the samples.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from typing import Any

import casadi as ca

from stribeck.model.balance import Balance
from stribeck.model.drive import Drive
from stribeck.model.effect import FrictionEffect
from stribeck.model.path import SignalPath
from stribeck.model.sensitivity import Sensitivity
from stribeck.model.slide import foreseen, slide
from stribeck.model.swing import swing
from stribeck.model.values import Expression


class Advance:
    """One step of a cut path, from sample to sample.

    Parameters
    ----------
    balance : Balance
    sample_time : float
        Between two samples, s.
    """

    def __init__(self, balance: Balance, sample_time: float) -> None:
        self.balance, self.sample_time = balance, sample_time

    def __call__(self, now: Drive, after: Drive, carried: Sensitivity) -> Sensitivity:
        """Return the states (nx, 1) one sample later, and their sensitivities by some parameters.

        Parameters
        ----------
        now, after : Drive
        carried : Sensitivity
            States now (the path's own symbols) and their sensitivities (nx, columns).
        """
        balance, sample_time, path, x = self.balance, self.sample_time, self.balance.path, carried.states
        mean = (after.position - now.position) / sample_time
        first, last = now.at(velocity=mean), after.at(velocity=mean)
        links = 2 * len(path.flexible)
        ahead = foreseen(balance, sample_time, now, x)
        swung = swing(balance, sample_time, now, after, carried, ahead) if links else carried
        out: list[Expression] = []
        if len(path.state_names) > links:
            # a bristle follows the distance moved, the mean velocity's; other laws the velocity of the instant
            own = x[: len(path.state_names)]
            given = own, path.p, balance.delay_at
            slid, moved = (self._relax(a.stacked, b.stacked, *given) for a, b in ((first, last), (now, after)))
            there = ca.vertcat(swung.states[:links], ahead[links:])
            known = _slid(balance, sample_time, first, last, x) | slide(balance, sample_time, now, after, x, there)
            bristles = _bristles(path)
            for i, name in enumerate(path.state_names[links:], links):
                out.append(known.get(name, slid[i] if name in bristles else moved[i]))
        rest, bent = ca.vertcat(*out), _bent(balance, x, dict(zip(path.state_names[links:], out, strict=True)))
        by_rest, by_bent = (
            ca.mtimes(ca.jacobian(part, x), carried.columns) + ca.jacobian(part, path.p)[:, list(carried.parameters)]
            for part in (rest, bent)
        )
        if not links:
            return replace(carried, states=ca.vertcat(rest, bent), columns=ca.vertcat(by_rest, by_bent))
        ends = links + balance.x.numel() - path.x.numel() - len(balance.bristled)  # of what links have with contacts
        states = ca.vertcat(swung.states[:links], rest, swung.states[links:ends], bent)
        columns = ca.vertcat(swung.columns[:links, :], by_rest, swung.columns[links:ends, :], by_bent)
        return replace(carried, states=states, columns=columns)

    @cached_property
    def _relax(self) -> ca.Function:
        """(drive now, drive after, states, p, T0) -> each effect state an exponential step later.

        Exact for a linear law under linear forcing; where states drive one another, each takes the change of the others
        into account. As a function it is called many times faster than it is written down again.
        """
        balance, h = self.balance, self.sample_time
        count = len(balance.path.state_names)
        state = ca.SX.sym("state", count)
        now, after = Drive.symbols(balance.n), Drive.symbols(balance.n, "1")
        rate_now, rate_after = (balance.derivatives(d, state) for d in (now, after))
        slopes = ca.jacobian(0.5 * (rate_now + rate_after), state)
        z = h * ca.diag(slopes)
        near = ca.fabs(z) < 1e-4
        safe = ca.if_else(near, 1.0, z)
        phi1 = ca.if_else(near, 1 + z / 2 + z**2 / 6, ca.expm1(safe) / safe)
        phi2 = ca.if_else(near, 0.5 + z / 6, (phi1 - 1) / safe)
        step = state + h * (phi1 * rate_now + phi2 * (rate_after - rate_now))
        slopes[:, : 2 * len(balance.path.flexible)] = 0.0  # links move by a step of their own, and so does a stand
        slopes[:, list(balance.path.stand_rows)] = 0.0
        coupling = ca.sparsify(slopes - ca.diag(ca.diag(slopes)))
        passed = ca.DM.eye(count) - h * ca.diag(phi2) @ coupling  # one another's change, over the same step
        step = state + (ca.solve(passed, step - state) if coupling.nnz() else step - state)
        inputs = [now.stacked, after.stacked, state, balance.path.p, balance.delay_at]
        return ca.Function("relax", inputs, [ca.densify(step)])


def _bristles(path: SignalPath) -> frozenset[str]:
    """Return the names of the states that carry a joint's friction."""
    placed = [(k, place.effect) for k, place in enumerate(path.placed) if isinstance(place.effect, FrictionEffect)]
    return frozenset(f"{k}.{state}" for k, effect in placed if effect.bristle for state in effect.states)


def _bent(balance: Balance, x: Any, moved: Mapping[str, Expression]) -> Any:
    """Return how far the motion has bent each bristle by the next sample (K, 1), N m, given the moved states."""
    path, out = balance.path, ca.SX(0, 1)
    begin = balance.x.numel() - len(balance.bristled)
    for i, j in enumerate(balance.bristled):
        k, effect = path.bristle(j)  # type: ignore[misc]
        before = path.states(k, x)
        out = ca.vertcat(out, x[begin + i] + sum(moved[f"{k}.{name}"] - before[name] for name in effect.states))
    return out


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
