"""Friction that trails the speed: what the laws of that family share."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, ClassVar

import casadi as ca

from stribeck.model.effect import FrictionEffect
from stribeck.model.scale import Scale
from stribeck.model.tustin import falls
from stribeck.model.values import Expression, Parameters, Signals, States

# poles that stand for a delay of the same mean, which they smear by a fifth: simulation, linearisation and export have
# states and no memory
DELAY = tuple(f"pole_{i}" for i in range(1, 25))
DELAY_UNITS = MappingProxyType(dict.fromkeys(DELAY, "rad/s"))
SAMPLES = 2.0  # by which what sets in between two of them, seen through a filter, trails the speed in any recording


class TrailingFriction(FrictionEffect):
    """Friction at a speed that follows by a chain of poles, one for each state, of the mean delay ``time``."""

    name = "frictional_lag"
    channel = "friction"
    shows = "velocity"
    kin = ("speed", "rest")
    elusive = True
    whole: ClassVar[bool] = False  # the viscous part trails as well

    def applies(self, arm: Any, joint: int) -> bool:
        """Return whether friction has a part that trails: one that falls with the speed, or else a viscous one."""
        sides = (arm.joints[joint].friction, arm.joints[joint].backward)
        return any(falls(own) or (self.whole and own.C2 > 0.0) for own in sides)

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        """Return a short and a long lag, s."""
        return ({"time": 0.02}, {"time": 0.08})

    def ordinary(self, values: Mapping[str, float], scale: Scale) -> bool:
        """Return whether the lag is one that filters leave in any recording."""
        return values["time"] < SAMPLES * scale.sample_time

    def speed(self, speed: Expression, s: Signals, x: States, p: Parameters) -> Expression:
        """Return the speed that the last pole has come to, rad/s."""
        return x[self.states[-1]]

    def derivatives(self, s: Signals, x: States, p: Parameters) -> dict[str, Expression]:
        """Return the rates of the poles, rad/s^2."""
        before = (ca.fabs(s.velocity), *(x[name] for name in self.states))
        rate = len(self.states) / p["time"]
        return {name: rate * (before[i] - x[name]) for i, name in enumerate(self.states)}

    def initial(self, s: Signals, p: Parameters) -> dict[str, Expression]:
        """Return the poles as they are after long motion at the speed of the first sample, rad/s."""
        return dict.fromkeys(self.states, ca.fabs(s.velocity))

    def with_viscous(self, constants: Parameters, x: States) -> Parameters:
        """Return constants whose viscous part trails as well."""
        return {**constants, "C0": constants["C0"] + constants["C2"] * x[self.states[-1]], "C2": 0.0}
