"""A mass at the tip that the model does not know of."""

from __future__ import annotations

from typing import final

from stribeck.model.effect import RigidBodyEffect
from stribeck.model.scale import Scale
from stribeck.model.values import Body, Parameter, Parameters


@final
class Payload(RigidBodyEffect):
    """A point mass at the tip of the last link; in some recordings alone, where these fall in two groups by it."""

    name = "payload"
    channel = "rigid_body"
    equation = r"m_n \to m_n + m, \quad \text{at } (l_n, 0)"
    symptom = "gravity and inertia of all joints off in the proportions of a mass at the tip"
    shows = "position"
    source = "Khalil & Dombre (2002), ch. 12"
    parameters = (Parameter("mass", "kg", "mass at the tip", 0.0, 0.0),)
    rescales = True

    def sites(self, n: int) -> tuple[int, ...]:
        return (n - 1,)

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        lever = 1.0 if scale.prismatic else max(scale.length, 1e-3)
        return ({"mass": 0.1 * scale.inertia / lever**2},)

    def body(self, body: Body, joint: int, p: Parameters) -> Body:
        mass, cx, cy = body.mass[joint], body.com_x[joint], body.com_y[joint]
        total = mass + p["mass"]
        x, y = (mass * cx + p["mass"] * body.length[joint]) / total, mass * cy / total
        spread = mass * ((cx - x) ** 2 + (cy - y) ** 2) + p["mass"] * ((body.length[joint] - x) ** 2 + y**2)
        return body.with_link(joint, mass=total, com_x=x, com_y=y, inertia=body.inertia[joint] + spread)
