"""The vector of all model parameters: names, units, values, priors and bounds, in one order."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from stribeck.arm import Arm, unit_at
from stribeck.model.effect import Effect, FrictionEffect, StandEffect, TransmissionEffect
from stribeck.model.values import Parameter

INERTIAL = {"mass": "kg", "com_x": "m", "com_y": "m", "inertia": "kg m^2", "rotor_inertia": "kg m^2"}
FRICTION = {"C0": "N m", "C1": "N m", "C2": "N m s/rad", "alpha": "rad/s"}
_POSITIVE = ("mass", "alpha")


@dataclass(frozen=True)
class Placed:
    """An effect at a joint (index), with its parameter values (SI). Those named in ``held`` are not fitted."""

    effect: Effect
    joint: int
    values: Mapping[str, float] = field(default_factory=dict)
    held: frozenset[str] = frozenset()

    @property
    def key(self) -> tuple[str, int]:
        """Effect name and joint."""
        return self.effect.name, self.joint

    def joints(self, n: int) -> tuple[int, ...]:
        """Return the joints, of an arm of ``n``, at which the law holds."""
        return tuple(range(n)) if self.effect.everywhere else (self.joint,)


def rival(effect: Effect, joint: int, placed: Sequence[Placed]) -> Placed | None:
    """Return which of the ``placed`` effects has an effect's place at a joint (index) already, if one has.

    There is one transmission and one bristle at a joint, and one stand under an arm.
    """
    kind = sole(effect)
    taken = (place for place in placed if kind and sole(place.effect) == kind)
    return next((place for place in taken if kind == "stand" or place.joint == joint), None)


def sole(effect: Effect) -> str:
    """Return what an effect is of which there can be one only, empty where there can be several."""
    if isinstance(effect, TransmissionEffect):
        return "transmission"
    if isinstance(effect, StandEffect):
        return "stand"
    return "bristle" if isinstance(effect, FrictionEffect) and effect.bristle else ""


@dataclass(frozen=True)
class Entry:
    """One model parameter.

    ``sd`` is the prior standard deviation around ``value`` (0: held, infinite: free within the bounds);
    ``owner`` is ``inertial``, ``friction`` or the position of its effect in the list of placed effects.
    """

    key: str
    joint: int
    name: str
    unit: str
    value: float
    sd: float
    lower: float
    upper: float
    log: bool
    owner: str | int


def layout(arm: Arm, placed: Sequence[Placed], middles: Sequence[float] | None = None) -> tuple[Entry, ...]:
    """Return the parameters of an arm and its effects, nominal ones first, in a fixed order.

    Where the joints' ``middles`` (n,) of a motion are known, rad, places are bounded about them, given ones apart.
    """
    entries: list[Entry] = []
    for j, name in enumerate(arm.names):
        entries += _inertial(arm, j, name) + _friction(arm, j, name)
    for k, place in enumerate(placed):
        entries += _effect(arm, k, place, None if middles is None else middles[place.joint])
    return tuple(entries)


def values_of(entries: Sequence[Entry]) -> np.ndarray:
    """Return the values (p,) in the order of the entries."""
    return np.array([entry.value for entry in entries])


def _inertial(arm: Arm, j: int, name: str) -> list[Entry]:
    joint = arm.joints[j]
    nominal = {
        "mass": joint.mass,
        "com_x": joint.com[0],
        "com_y": joint.com[1],
        "inertia": joint.inertia,
        "rotor_inertia": joint.rotor_inertia,
    }
    entries = []
    for key, unit in INERTIAL.items():
        value, shown = nominal[key], unit_at(unit, joint.kind)
        lower = -math.inf if key.startswith("com") else _least(key, value)
        sd = arm.deviation(j, key, value)
        entries.append(Entry(f"{name}.{key}", j, key, shown, value, sd, lower, math.inf, False, "inertial"))
    return entries


def _friction(arm: Arm, j: int, name: str) -> list[Entry]:
    joint = arm.joints[j]
    sides = {"friction": joint.friction}
    if joint.backward != joint.friction:
        sides["backward"] = joint.backward
    entries = []
    for side, constants in sides.items():
        for key, unit in FRICTION.items():
            value, shown = float(getattr(constants, key)), unit_at(unit, joint.kind)
            sd = joint.tolerance.get(key, arm.tolerance.friction * abs(value))
            if key == "alpha" and constants.C1 == 0.0:
                sd = 0.0  # without a bend the decay constant means nothing
            lower = _least(key, value)
            entries.append(Entry(f"{name}.{side}.{key}", j, key, shown, value, sd, lower, math.inf, False, "friction"))
    return entries


def _least(key: str, value: float) -> float:
    """Return the lower bound of a value: next to nothing for what is divided by, else nothing."""
    return min(1e-6, 1e-3 * value) if key in _POSITIVE else 0.0


def _effect(arm: Arm, k: int, place: Placed, middle: float | None) -> list[Entry]:
    name = arm.names[place.joint]
    return [
        Entry(
            f"{place.effect.name}[{name}].{parameter.name}",
            place.joint,
            parameter.name,
            unit_at(parameter.unit, arm.joints[place.joint].kind),
            float(place.values.get(parameter.name, parameter.null)),
            0.0 if parameter.name in place.held else math.inf,
            *_bounds(parameter, middle, place.values.get(parameter.name, parameter.null) if place.values else None),
            parameter.log,
            k,
        )
        for parameter in place.effect.parameters
    ]


def _bounds(parameter: Parameter, middle: float | None, stated: float | None) -> tuple[float, float]:
    """Return the bounds of a fit; of a place those about the middle of the motion, unless it is stated beyond."""
    free = parameter.lower, parameter.upper
    if middle is None or not parameter.place:
        return free
    lower, upper = parameter.bounds(middle)
    return (lower, upper) if stated is None or lower <= stated <= upper else free
