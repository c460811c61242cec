"""What the records tell of each joint at one sample: the command that acts there, and the true motion."""

from __future__ import annotations

import casadi as ca

from stribeck.model.asked import asked_once
from stribeck.model.drive import PAST, Drive
from stribeck.model.effect import ActuatorEffect, SensingEffect
from stribeck.model.path import SignalPath
from stribeck.model.values import Expression, Signals


class Told:
    """The records with what delays and sensors did to them undone.

    Attributes
    ----------
    delay_at : casadi.SX (placed, 1)
        Delays by which the drive was moved already, s: the rest of a delay is taken to first order.
    """

    def __init__(self, path: SignalPath) -> None:
        self.path, self.n = path, path.n
        self.delay_at = ca.SX.sym("T0", len(path.placed))

    def command(self, d: Drive, joint: int) -> Expression:
        """Return the command, delayed. The data are delayed by T0 already; the rest is to first order."""
        command = d.command[joint]
        for k, effect in self.path.at(joint, ActuatorEffect):
            if effect.delays == "command":
                command = command - d.command_rate[joint] * (self.path.parameters(k)["time"] - self.delay_at[k])
        return command

    @asked_once
    def motion(self, d: Drive) -> list[Signals]:
        """Return the true signals of each joint on the motor side; the link's where it is rigid."""
        signals = []
        for j in range(self.n):
            y, dy, ddy = self._recorded(d, j)
            q, dq, ddq = self._true(j, y, dy, ddy)
            known = {name: getattr(d, name)[j] for name in ("sliding", *PAST)}
            signals.append(Signals(d.time, q, dq, ddq, q, dq, **known))
        return signals

    def _true(self, joint: int, y: Expression, dy: Expression, ddy: Expression) -> tuple[Expression, ...]:
        """Return true position, velocity and acceleration from what the sensor gave."""
        if not self.path.at(joint, SensingEffect):
            return y, dy, ddy
        q = self.path.true_position(joint, ca.SX(y))
        slope, curve = self.path.sensed(joint, q)
        dq = dy / slope
        return q, dq, (ddy - curve * dq**2) / slope

    def _recorded(self, d: Drive, joint: int) -> tuple[Expression, Expression, Expression]:
        """Return position, velocity and acceleration as the sensor gave them, the lateness of the record undone."""
        y, dy, ddy = d.position[joint], d.velocity[joint], d.acceleration[joint]
        for k, effect in self.path.at(joint, SensingEffect):
            if effect.delays == "position":  # the data are moved by T0 already; the rest is to first order
                ahead = self.path.parameters(k)["time"] - self.delay_at[k]
                y, dy = y + d.position_rate[joint] * ahead, dy + d.velocity_rate[joint] * ahead
                ddy = ddy + d.acceleration_rate[joint] * ahead
        return y, dy, ddy
