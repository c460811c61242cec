"""Units of a joint's quantities: those of a rotation, or of a straight axis."""

from __future__ import annotations

import re

BASES = ("kg", "m", "s", "rad", "N", "W", "Hz", "1")


def unit_at(text: str, kind: str) -> str:
    """Return a unit as it is at a joint of a kind.

    Parameters
    ----------
    text : str
        As of a rotation, such as ``N m s/rad``.
    kind : str
        ``revolute``, or ``prismatic``: rad is then m, N m is N and kg m^2 is kg.
    """
    if kind != "prismatic":
        return text
    return text.replace("kg m^2", "kg").replace("N m", "N").replace("rad", "m")


def with_unit(said: str, unit: str) -> str:
    """Return what is said of a value with its unit; that of a number, "1", is left out."""
    return said if unit in ("", "1") else f"{said} {unit}"


def factors(text: str) -> list[tuple[str, float]]:
    """Return (base, power) of each factor of a unit: products are separated by spaces, what follows a slash divides."""
    if not text:
        return []
    above, *below = text.split("/")
    found = [_factor(part, 1.0) for part in above.split()]
    found += [_factor(part, -1.0) for group in below for part in group.strip("()").split()]
    return [(base, power) for base, power in found if base != "1"]


def is_unit(text: str) -> bool:
    """Return whether a text is a unit that `factors` can take apart."""
    try:
        factors(text)
    except ValueError:
        return False
    return True


def _factor(text: str, sign: float) -> tuple[str, float]:
    found = re.fullmatch(r"([A-Za-z]+|1)(?:\^([0-9.]+))?", text)
    if found is None or found[1] not in BASES:
        raise ValueError(f"unit {text!r} is not known")
    return found[1], sign * float(found[2] or 1.0)
