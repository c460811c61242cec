"""Units of a joint's quantities: those of a rotation, or of a straight axis."""

from __future__ import annotations


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
