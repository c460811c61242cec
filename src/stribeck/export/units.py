"""Units as the XML wants them: a name that tools can read, and its powers of the base units."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

from stribeck.arm import factors, unit_at

_BASE = {
    "kg": {"kg": 1},
    "m": {"m": 1},
    "s": {"s": 1},
    "rad": {"rad": 1},
    "N": {"kg": 1, "m": 1, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "Hz": {"s": -1},
    "1": {},
}
_ORDER = ("kg", "m", "s", "rad")

_DISPLAY = {
    "rad": (("deg", 180.0 / pi),),
    "rad/s": (("deg/s", 180.0 / pi), ("rpm", 30.0 / pi)),
    "rad/s2": (("deg/s2", 180.0 / pi),),
    "m": (("mm", 1e3),),
    "s": (("ms", 1e3),),
}
_TYPES = {
    "rad": ("Angle", "Angle"),
    "rad/s": ("AngularVelocity", "AngularVelocity"),
    "rad/s2": ("AngularAcceleration", "AngularAcceleration"),
    "N.m": ("Torque", "Torque"),
    "kg": ("Mass", "Mass"),
    "kg.m2": ("Inertia", "MomentOfInertia"),
    "m": ("Length", "Length"),
    "m/s": ("Velocity", "Velocity"),
    "m/s2": ("Acceleration", "Acceleration"),
    "N": ("Force", "Force"),
    "W": ("Power", "Power"),
    "s": ("Time", "Time"),
    "Hz": ("Frequency", "Frequency"),
    "N.m/rad": ("RotationalStiffness", "RotationalSpringConstant"),
    "N.m.s/rad": ("RotationalDamping", "RotationalDampingConstant"),
}


@dataclass(frozen=True)
class Unit:
    """A unit of the model description.

    Attributes
    ----------
    name : str
        As Modelica writes it: ``N.m.s/rad``, ``kg.m2``.
    powers : tuple of (str, int) or None
        Of the base units; None where one is not whole, which the standard cannot say.
    display : tuple of (str, float)
        Display units and what a value is multiplied by.
    type_name, quantity : str or None
        Of its type definition.
    """

    name: str
    powers: tuple[tuple[str, int], ...] | None
    display: tuple[tuple[str, float], ...]
    type_name: str | None
    quantity: str | None


def unit_of(text: str, *, prismatic: bool = False) -> Unit:
    """Return the unit that the package writes as ``text``, such as ``N m s/rad``.

    Parameters
    ----------
    text : str
        Products are separated by spaces; what follows a slash divides.
    prismatic : bool
        Whether rad stands for m, N m for N and kg m^2 for kg, as everywhere for a prismatic axis.
    """
    parts = factors(unit_at(text, "prismatic") if prismatic else text)
    above = ".".join(_power(base, power) for base, power in parts if power > 0) or "1"
    below = [_power(base, -power) for base, power in parts if power < 0]
    name = "/".join([above, *below])
    type_name, quantity = _TYPES.get(name, (None, None))
    return Unit(name, _powers(parts), _DISPLAY.get(name, ()), type_name, quantity)


def _power(base: str, power: float) -> str:
    return base if power == 1.0 else f"{base}{power:g}"


def _powers(parts: list[tuple[str, float]]) -> tuple[tuple[str, int], ...] | None:
    total = dict.fromkeys(_ORDER, 0.0)
    for base, power in parts:
        for name, own in _BASE[base].items():
            total[name] += power * own
    if any(value != int(value) for value in total.values()):
        return None
    return tuple((name, int(value)) for name, value in total.items() if value)
