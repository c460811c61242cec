"""A wall in the plane that the arm's tip runs into."""

from __future__ import annotations

from typing import Any, final

from stribeck.model.effect import ExternalEffect
from stribeck.model.planes import plane_force, plane_starts, planes_from
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters, States, Tip
from stribeck.model.waves import Trace

EXPONENT = 1.5  # of a ball on a plane


@final
class ContactPlane(ExternalEffect):
    """A soft straight wall beyond a line in the arm's plane, without friction along it, on the arm's own base."""

    name = "contact"
    law = "plane"
    channel = "external"
    equation = r"\tau = J^T n\, k \delta^{3/2} (1 + c \dot\delta), \quad \delta = \max(n \cdot p - d, 0)"
    symptom = "residuals at all joints, as of a force on the tip, beyond one line in the plane and nothing before it"
    shows = "position"
    source = "Hunt & Crossley (1975)"
    kin = ("curve",)
    edged = True
    everywhere = True
    parameters = (
        Parameter("stiffness", "N/m^1.5", "stiffness of the wall", 0.0, 0.0),
        Parameter("direction", "rad", "of the normal into the wall, from the base frame's x", 0.0, -10.0, 10.0),
        Parameter("distance", "m", "of the wall from the first axis along the normal", 0.0, -20.0, 20.0),
        Parameter("damping", "s/m", "damping over stiffness", 0.0, 0.0, 20.0),
    )

    def sites(self, n: int) -> tuple[int, ...]:
        return (0,)

    def applies(self, arm: Any, joint: int) -> bool:
        return len(arm.joints) > 1  # what stops a single joint is a wall on its own angle

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return plane_starts(scale, EXPONENT)

    def starts_from(self, scale: Scale, trace: Trace) -> tuple[dict[str, float], ...]:
        return planes_from(scale, trace, EXPONENT)

    def tip_force(self, tip: Tip, x: States, p: Parameters) -> tuple[Expression, Expression]:
        return plane_force(tip, p, EXPONENT)
