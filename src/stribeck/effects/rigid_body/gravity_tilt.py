"""A base that is not level."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import final

from stribeck.model.effect import RigidBodyEffect
from stribeck.model.scale import Scale
from stribeck.model.values import STANDARD_GRAVITY, Body, Parameter, Parameters

LEVEL = 0.05  # m/s^2: no stand is level to better than 5 mrad
MORE = 1.05  # of gravity, that no tilt makes: it is turned, and rounded at most


@final
class GravityTilt(RigidBodyEffect):
    """A change of gravity in the arm's plane, as a tilted base gives it."""

    name = "gravity_tilt"
    channel = "rigid_body"
    equation = r"g \to g + (g_x, g_y)"
    symptom = "a static torque at every joint that depends on the pose as gravity does"
    shows = "position"
    source = "Khalil & Dombre (2002), ch. 9"
    parameters = (
        Parameter("x", "m/s^2", "change of gravity along the base frame's x", 0.0, -20.0, 20.0),
        Parameter("y", "m/s^2", "change of gravity along the base frame's y", 0.0, -20.0, 20.0),
    )
    whole_arm = True

    def sites(self, n: int) -> tuple[int, ...]:
        return (0,)

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return ({"x": 0.5, "y": 0.0}, {"x": 0.0, "y": 0.5})

    def ordinary(self, values: Mapping[str, float], scale: Scale) -> bool:
        return math.hypot(values["x"], values["y"]) < LEVEL

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        """Return whether there is no more gravity than on earth: a tilt turns it.

        More of it stands for something else, such as a link that is shorter than in the arm file: beside masses that
        are re-tuned it does the same.
        """
        x, y = scale.gravity
        return math.hypot(x + values["x"], y + values["y"]) < MORE * STANDARD_GRAVITY

    def body(self, body: Body, joint: int, p: Parameters) -> Body:
        return replace(body, gravity=(body.gravity[0] + p["x"], body.gravity[1] + p["y"]))
