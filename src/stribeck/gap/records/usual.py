"""What every arm has some of, in words."""

from __future__ import annotations

from stribeck.arm import Arm, unit_at, with_unit
from stribeck.model.layout import Placed


def no_more_than_any(place: Placed, arm: Arm) -> str:
    """Return an effect with its values, as no more than any joint has."""
    if place.effect.delays:
        return f"{1e3 * place.values['time']:.2g} ms late, as any drive may be"
    kind = arm.joints[place.joint].kind
    values = ", ".join(
        with_unit(f"{p.description} {place.values[p.name]:.3g}", unit_at(p.unit, kind)) for p in place.effect.parameters
    )
    return f"{place.effect.label} ({values}), no more than any joint has"
