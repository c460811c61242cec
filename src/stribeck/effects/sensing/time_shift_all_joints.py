"""The position records of all joints, late or early by the same against the torque."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, final

from stribeck.model.effect import SensingEffect
from stribeck.model.scale import PROMPT, Scale
from stribeck.model.values import Parameter


@final
class TimeShiftAllJoints(SensingEffect):
    """Two clocks, one of the positions and one of the torques: positive where the positions are late.

    Joint by joint the shift is hard to find, for each moves with what the others do. Forward, where the record's clock
    counts, all commands come late (or early) by as much.
    """

    name = "time_shift"
    law = "all_joints"
    channel = "sensing"
    equation = r"y_i(t) = q_i(t - T) \text{ at all joints}"
    symptom = "a residual at every joint in proportion to the rate of its command, of either sign"
    shows = "command rate"
    source = "Rehder, Siegwart & Furgale (2016), temporal calibration of sensors"
    kin = ("late",)
    filters = True
    parameters = (Parameter("time", "s", "lateness of the position records", 0.0, -0.2, 0.2),)
    delays = "position"
    everywhere = True

    def sites(self, n: int) -> tuple[int, ...]:
        return (0,)

    def applies(self, arm: Any, joint: int) -> bool:
        return len(arm.joints) > 1

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        # a fit finds its way from some 15 ms off
        return tuple({"time": side * time} for time in (0.005, 0.015, 0.035) for side in (1.0, -1.0))

    def ordinary(self, values: Mapping[str, float], scale: Scale) -> bool:
        return abs(values["time"]) < PROMPT
