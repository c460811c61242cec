"""One variable of an FMU, of an arm or of a controller."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from stribeck.export.units import Unit


@dataclass(frozen=True)
class Variable:
    """One variable.

    Attributes
    ----------
    name, description : str
    vr : int
        Value reference, unique over all types.
    causality, variability, initial : str
        As in the standard; ``initial`` is empty where the standard gives it or there is none.
    unit : Unit or None
    start, lower, upper : float or None
    real : bool
        Floating point; else a 32-bit integer.
    derivative_of : int or None
        Value reference of the state whose derivative it is.
    reinit : bool
        Whether an event may make it jump.
    """

    name: str
    vr: int
    causality: str
    variability: str
    description: str
    unit: Unit | None = None
    initial: str = ""
    start: float | None = None
    lower: float | None = None
    upper: float | None = None
    real: bool = True
    derivative_of: int | None = None
    reinit: bool = False


def units_of(variables: Iterable[Variable]) -> list[Unit]:
    """Return every unit that occurs, once, by name."""
    found = {v.unit.name: v.unit for v in variables if v.unit}
    return [found[name] for name in sorted(found)]


def index_of(variables: Sequence[Variable], vr: int) -> int:
    """Return the place of a variable in the model description, counted from 1 as FMI 2 does."""
    return next(i for i, v in enumerate(variables, 1) if v.vr == vr)
