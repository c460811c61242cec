"""A base that gives way."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import final

from stribeck.model.effect import TransmissionEffect
from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameter, Parameters
from stribeck.model.waves import Trace, ringing

DAMPED = 0.2  # of critical, as a stand on rubber may be: more is no stand, but a shaft's ringing that noise blurs
LIGHTEST = 0.3  # of the inertia of the links: a stand, with the arm's own base on it, that rocks with less is none


@final
class BaseFlexibility(TransmissionEffect):
    """The stand rocks about the first axis on a spring and damper, driven by the reaction of the first joint.

    The encoder tells the angle between base and link, so that the first link's own angle is the sum of both. It takes
    the place of a compliance of the first joint, whose law it has where the base is light.
    """

    name = "base_flexibility"
    law = "rocking"
    channel = "rigid_body"
    equation = r"J_b \ddot\varphi + d \dot\varphi + k \varphi = -\tau_1, \quad q_{\mathrm{link}} = q_1 + \varphi"
    symptom = "a slow, lightly damped resonance at the first joint, which the joints after it feel as well"
    shows = "frequency"
    source = "Lew & Moon (2001), manipulators on a compliant base"
    filters = True
    nonlinear = True
    whole_arm = True
    alone = "a mass that swings on the link (a soft tool or load)"
    parameters = (
        Parameter("stiffness", "N m/rad", "stiffness of the stand", math.inf, 1e-8, 1e11, log=True),
        Parameter("damping", "N m s/rad", "damping of the stand", 0.0, 1e-9, 1e8, log=True),
        Parameter("inertia", "kg m^2", "inertia of what rocks with the base, the arm apart", 1.0, 1e-12, 1e6, log=True),
    )

    def sites(self, n: int) -> tuple[int, ...]:
        return (0,)

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return tuple(_start(scale, *way) for way in ((1.5, 1.0), (4.0, 1.0), (10.0, 1.0), (12.0, 0.4), (25.0, 0.5)))

    def starts_from(self, scale: Scale, trace: Trace) -> tuple[dict[str, float], ...]:
        return (*self.starts(scale), *(_start(scale, hertz, 1.0) for hertz in ringing(trace, (0.8, 25.0))))

    def plausible(self, values: Mapping[str, float], scale: Scale) -> bool:
        # On a light base the law is that of a compliant first joint whose rotor takes part of the link's inertia: with
        # J the link's, J_b J / (J_b + J) of it. It then fits what the data sheet divides wrongly between the two.
        critical = 2.0 * math.sqrt(values["stiffness"] * values["inertia"])
        return values["inertia"] > LIGHTEST * scale.link and values["damping"] < DAMPED * critical

    def transmitted(self, deflection: Expression, rate: Expression, p: Parameters) -> Expression:
        return p["stiffness"] * deflection + p["damping"] * rate

    def deflection(self, torque: Expression, p: Parameters) -> Expression:
        return torque / p["stiffness"]

    def carrier(self, p: Parameters) -> Expression:
        return p["inertia"]


def _start(scale: Scale, hertz: float, base: float) -> dict[str, float]:
    """Return the values of a stand that rings so fast, its inertia over the arm's as given."""
    omega, whole = 6.2832 * hertz, scale.inertia * (1.0 + base)
    return {"stiffness": whole * omega**2, "damping": 0.1 * whole * omega, "inertia": scale.inertia * base}
