"""A position record that is late or early against the torque."""

from __future__ import annotations

from typing import final

from stribeck.model.effect import ActuatorEffect, Parameter, Scale


@final
class TimeShift(ActuatorEffect):
    """Clocks of the two records that differ: positive where the position is late.

    Seen from the position's clock the command is late by the same time, so the machinery that delays a command
    serves here too; unlike a delay in the drive it may be negative.
    """

    name = "time_shift"
    channel = "sensing"
    equation = r"y(t) = q(t - T)"
    symptom = "a residual in proportion to the rate of the command, of either sign"
    source = "Swevers, Verdonck & De Schutter (2007), time alignment of robot data"
    parameters = (Parameter("time", "s", "lateness of the position record", 0.0, -0.2, 0.2),)
    delays = "command"

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return ({"time": -0.01},)
