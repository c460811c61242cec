"""Cables or hoses that pull a joint back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

from stribeck.model.effect import ExternalEffect
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States


@final
class CableSpring(ExternalEffect):
    """A linear spring on the joint's link."""

    name = "cable_spring"
    law = "linear"
    channel = "external"
    equation = r"\tau = k (q - q_0)"
    symptom = "a static torque that grows with the joint's own position, whatever the pose of the others"
    shows = "position"
    source = "Hooke's law"
    kin = ("curve",)
    parameters = (
        Parameter("stiffness", "N m/rad", "stiffness", 0.0, 0.0),
        Parameter("rest", "rad", "position without torque", reach=3.2),
    )

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        size = 0.1 * scale.torque / scale.travel
        return ({"stiffness": size, "rest": scale.middle},)

    def ordinary(self, values: Mapping[str, float], scale: Scale) -> bool:
        return values["stiffness"] * scale.furthest(values["rest"]) < scale.stray

    def torque(self, s: Signals, x: States, p: Parameters) -> Expression:
        return p["stiffness"] * (s.link_position - p["rest"])
