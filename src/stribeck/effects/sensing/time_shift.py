"""A position record that is late or early against the torque."""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

from stribeck.model.effect import SensingEffect
from stribeck.model.scale import PROMPT, Scale
from stribeck.model.values import Parameter


@final
class TimeShift(SensingEffect):
    """Clocks of the two records that differ: positive where the position is late.

    The cut moves the recorded motion back in time, and so does a prediction along a recording. In a loop or an FMU,
    where the record's clock counts, the joint's command comes late (or early) by as much: exact but for the coupling
    of joints that are not late alike.
    """

    name = "time_shift"
    law = "one_joint"
    channel = "sensing"
    equation = r"y(t) = q(t - T)"
    symptom = "a residual in proportion to the rate of the command, of either sign, in the coupling to other joints too"
    shows = "command rate"
    source = "Rehder, Siegwart & Furgale (2016), temporal calibration of sensors"
    kin = ("late",)
    filters = True
    parameters = (Parameter("time", "s", "lateness of the position record", 0.0, -0.2, 0.2),)
    delays = "position"

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        # a fit finds its way from some 15 ms off
        return tuple({"time": side * time} for time in (0.005, 0.015, 0.035) for side in (1.0, -1.0))

    def ordinary(self, values: Mapping[str, float], scale: Scale) -> bool:
        return abs(values["time"]) < PROMPT
