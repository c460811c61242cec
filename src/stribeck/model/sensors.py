"""The sensors of an arm with effects: the recorded position from the true one, and back."""

from __future__ import annotations

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

    def sensed(self, joint: int, position: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Return first and second derivative of a joint's recorded position by the true one (a symbol)."""
        slope = ca.jacobian(self.measured(joint, position), position)
        return ca.fmax(slope, SLOPE), ca.jacobian(slope, position)

    def true_position(self, joint: int, recorded: Expression) -> Expression:
        """Return the true position of a joint from the recorded one, rad: its laws undone from last to first."""
        position = recorded
        for k, effect in reversed(self._sensing(joint)):
            position = self._undone(effect, self.parameters(k), position)
        return position

    def _undone(self, effect: SensingEffect, p: Parameters, recorded: Expression) -> Expression:
        """Return the position from which one law makes the recorded one."""
        at = ca.SX.sym("position")
        error = effect.measured(at, p) - at
        if not ca.depends_on(ca.SX(error), at):
            return recorded - error

        def beyond(position: Expression) -> Expression:
            return ca.substitute(effect.measured(at, p), at, position) - recorded

        # no further than its error there over its least slope
        position = bisected(beyond, recorded, ca.fabs(beyond(recorded)) / SLOPE, BISECTIONS)
        step = (effect.measured(at, p) - recorded) / ca.fmax(1.0 + ca.jacobian(error, at), SLOPE)
        for _ in range(INVERSION_STEPS):
            position = position - ca.substitute(step, at, position)
        return position

    def _sensing(self, joint: int) -> list[tuple[int, SensingEffect]]:
        """Return (number, effect) of a joint's sensor laws from the true position to the recorded one."""
        return sorted(self.at(joint, SensingEffect), key=lambda found: found[1].counted)
