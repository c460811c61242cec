"""Cables or hoses that stiffen as they are stretched or bent."""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

from stribeck.model.effect import ExternalEffect
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, Signals, States


@final
class CableSpringHardening(ExternalEffect):
    """A spring on the joint's link with a cubic part; the other law has none."""

    name = "cable_spring"
    law = "hardening"
    channel = "external"
    equation = r"\tau = k (q - q_0) + k_3 (q - q_0)^3"
    symptom = "a static torque that grows ever faster with the joint's distance from a place of its own"
    shows = "position"
    source = "Duffing (1918)"
    kin = ("curve",)
    parameters = (
        Parameter("stiffness", "N m/rad", "stiffness at rest", 0.0, 0.0),
        Parameter("rest", "rad", "position without torque", reach=3.2),
        Parameter("cubic", "N m/rad^3", "rise of the stiffness", 0.0, 0.0),
    )

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        size = 0.1 * scale.torque / scale.travel
        return ({"stiffness": 0.5 * size, "rest": scale.middle, "cubic": size / scale.travel**2},)

    def ordinary(self, values: Mapping[str, float], scale: Scale) -> bool:
        away = scale.furthest(values["rest"])
        return values["stiffness"] * away + values["cubic"] * away**3 < scale.stray

    def torque(self, s: Signals, x: States, p: Parameters) -> Expression:
        away = s.link_position - p["rest"]
        return p["stiffness"] * away + p["cubic"] * away**3
