"""The sensors of an arm with effects: the recorded position from the true one, and back."""

from __future__ import annotations

from functools import cache
from typing import Any

import casadi as ca

from stribeck.model.bisect import bisected
from stribeck.model.effect import SensingEffect
from stribeck.model.symbols import Symbols
from stribeck.model.values import Expression, Parameters

BISECTIONS = 12  # before Newton's method, which undo a sensor's law: to where its slope is nearly that of the place
INVERSION_STEPS = 4  # of Newton's method
SLOPE = 0.05  # of a sensor's law, at least: below, as in a fit that tries one, two positions are read nearly alike


class Sensors(Symbols):
    """The last stage of a signal path, over the symbols for all parameters."""

    def measured(self, joint: int, position: Expression) -> Expression:
        """Return the recorded position of a joint from the true one, rad."""
        for k, effect in self._sensing(joint):
            position = effect.measured(position, self.parameters(k))
        return position

    def sensed(self, joint: int, position: Expression) -> tuple[Expression, Expression]:
        """Return first and second derivative of a joint's recorded position by the true one."""
        sensing = self._sensing(joint)
        slope, curve = _slopes(tuple(effect for _, effect in sensing))(position, *[self._values(k) for k, _ in sensing])
        return slope, curve

    def true_position(self, joint: int, recorded: Expression) -> Expression:
        """Return the true position of a joint from the recorded one, rad: its laws undone from last to first."""
        position = recorded
        for k, effect in reversed(self._sensing(joint)):
            position = _undone(effect)(position, self._values(k))
        return position

    def _sensing(self, joint: int) -> list[tuple[int, SensingEffect]]:
        """Return (number, effect) of a joint's sensor laws from the true position to the recorded one."""
        return sorted(self.at(joint, SensingEffect), key=lambda found: found[1].counted)

    def _values(self, k: int) -> Any:
        return ca.vertcat(*self.parameters(k).values())


# as functions they are called many times faster than they are written down again


@cache
def _slopes(effects: tuple[SensingEffect, ...]) -> ca.Function:
    """Return (true position, values of each law) -> first and second derivative of the recorded position."""
    at, values = ca.SX.sym("position"), [_symbols(effect) for effect in effects]
    reading = at
    for effect, own in zip(effects, values, strict=True):
        reading = effect.measured(reading, _named(effect, own))
    slope = ca.jacobian(ca.SX(reading), at)
    return ca.Function("slopes", [at, *values], [ca.fmax(slope, SLOPE), ca.densify(ca.jacobian(slope, at))])


@cache
def _undone(effect: SensingEffect) -> ca.Function:
    """Return (recorded position, values of its law) -> the position from which the law makes the recorded one."""
    at, recorded, values = ca.SX.sym("position"), ca.SX.sym("recorded"), _symbols(effect)
    p = _named(effect, values)
    error = effect.measured(at, p) - at
    if not ca.depends_on(ca.SX(error), at):
        return ca.Function("undone", [recorded, values], [recorded - error])

    def beyond(position: Expression) -> Expression:
        return ca.substitute(effect.measured(at, p), at, position) - recorded

    # no further than its error there over its least slope
    position = bisected(beyond, recorded, ca.fabs(beyond(recorded)) / SLOPE, BISECTIONS)
    step = (effect.measured(at, p) - recorded) / ca.fmax(1.0 + ca.jacobian(error, at), SLOPE)
    for _ in range(INVERSION_STEPS):
        position = position - ca.substitute(step, at, position)
    return ca.Function("undone", [recorded, values], [position])


def _symbols(effect: SensingEffect) -> ca.SX:
    return ca.SX.sym("values", len(effect.parameters))


def _named(effect: SensingEffect, values: ca.SX) -> Parameters:
    return {parameter.name: values[i] for i, parameter in enumerate(effect.parameters)}
