"""Friction that remembers what its joint has been through: what the laws of that family share."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence

import casadi as ca

from stribeck.model.effect import FrictionEffect, Upon
from stribeck.model.values import Expression, Parameters, Signals, States

LEAST = 0.05  # of the level: whatever the past, some friction is left
SHORTEST = 1e-9  # s


class RememberingFriction(FrictionEffect):
    """All friction scaled by 1 + ``change`` times a state, the memory."""

    name = "history"
    channel = "friction"
    upon = Upon.ALL
    shows = "time"
    elusive = True

    def level(self, level: Expression, direction: float, s: Signals, x: States, p: Parameters) -> Expression:
        """Return the level, N m, as the memory scales it.

        Parameters
        ----------
        level : expression
            Without it, N m.
        direction : float
            1 or -1; both are scaled alike.
        s : Signals
            Of the joint.
        x, p : mapping of str to expression
            States and parameters of the effect.
        """
        return level * self._factor(x, p)

    def viscous(self, torque: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        """Return the torque without a sign function, N m, as the memory scales it."""
        return torque * self._factor(x, p)

    def _factor(self, x: States, p: Parameters) -> Expression:
        return ca.fmax(1.0 + p["change"] * x[self.states[0]], LEAST)


class WarmedFriction(RememberingFriction):
    """A memory that motion charges and time drains: warmth.

    Between two recordings a part of it is ``kept``. What a joint brings into one is what all those before it, taken as
    equally long and brisk, have left; before the first, ``start``.
    """

    @abstractmethod
    def nears(self, speed: Expression, s: Signals, p: Parameters) -> tuple[Expression, Expression]:
        """Return the warmth in which a steady speed, rad/s, ends and how fast it nears that, 1/s."""

    def initial(self, s: Signals, p: Parameters) -> dict[str, Expression]:
        """Return the warmth that all recordings before, and what came before of this one, have left."""
        ends, rate = self.nears(s.travelled / ca.fmax(s.recorded, SHORTEST), s, p)
        left = p["kept"] * ca.exp(-s.recorded * rate / ca.fmax(s.recordings, 1.0))  # of one mean recording
        again = (p["kept"] - left) * ends * (1.0 - left**s.recordings) / (1.0 - left) + left**s.recordings * p["start"]
        first = ca.if_else(s.recordings > 0.0, again, p["start"])
        ends, rate = self.nears(s.led / ca.fmax(s.lead, SHORTEST), s, p)
        cools = ca.exp(-s.lead * rate)  # in the part of this recording that came before
        return {self.states[0]: cools * first + (1.0 - cools) * ends}

    def on_average(self, values: Mapping[str, float], starts: Sequence[Signals]) -> dict[str, float]:
        """Return the values with the mean warmth of all recordings' starts as the first one's."""
        warmth = [float(self.initial(s, values)[self.states[0]]) for s in starts]
        return {**values, "start": sum(warmth) / len(warmth)}
