"""The effects that an arm file states, each at its joints and checked; and back to the entries of a file."""

from __future__ import annotations

import math
from collections.abc import Mapping

from stribeck.arm import Arm, EffectEntry, unit_at, with_unit
from stribeck.effects.registry import effect_named
from stribeck.errors import InputError
from stribeck.model.effect import Effect, RigidBodyEffect, SensingEffect
from stribeck.model.layout import Placed, rival, sole
from stribeck.model.values import Parameter


def placed_effects(arm: Arm, source: str = "") -> tuple[Placed, ...]:
    """Return the effects of an arm, each at its joints, parameters checked.

    Parameters
    ----------
    arm : Arm
    source : str
        The file that it comes from, for the message; the arm's name where none is given.

    Raises
    ------
    InputError
        One line: the source, the key, what was found there and what to do.
    """
    source = source or f"arm {arm.name!r}"
    placed: list[Placed] = []
    for k, entry in enumerate(arm.effects):
        where = f"{source}: effects[{k}]"
        for joint in entry.joints:
            place = _place(arm, entry, joint, where)
            for other in placed:
                shared = set(place.joints(arm.n)) & set(other.joints(arm.n))
                once = shared or place.effect.whole_arm
                if once and other.effect.name == place.effect.name:
                    name = arm.names[min(shared)] if shared else joint
                    raise InputError(f"{where}: {place.effect.name} is given twice", name, "keep one law at a joint")
            if before := rival(place.effect, place.joint, placed):
                kind = sole(place.effect)
                what = f"{where}: {place.effect.name} beside {before.effect.name}, where there can be one {kind} only"
                raise InputError(what, joint, "keep one of them")
            placed.append(place)
    return tuple(placed)


def acting_effects(arm: Arm) -> tuple[Placed, ...]:
    """Return the effects of an arm, each at its joints, but for those whose values make them vanish."""
    return tuple(place for place in placed_effects(arm) if not vanishes(place))


def stated_effects(arm: Arm) -> tuple[Placed, ...]:
    """Return the effects of an arm that its file gives values, each at its joints: those that a fit may start from.

    A value at its null is one, but for an infinite one, which no fit leaves.
    """
    return tuple(place for place in placed_effects(arm) if place.values and not _infinite(place))


def vanishes(place: Placed) -> bool:
    """Tell whether an effect's values make it vanish."""
    return _infinite(place) or all(_at_null(place).values())


def _infinite(place: Placed) -> bool:
    return any(flag for parameter, flag in _at_null(place).items() if not math.isfinite(parameter.null))


def _at_null(place: Placed) -> dict[Parameter, bool]:
    return {p: place.values.get(p.name, p.null) == p.null for p in place.effect.parameters}


def _place(arm: Arm, entry: EffectEntry, joint: str, where: str) -> Placed:
    effect = effect_named(entry.effect, entry.law, f"{where}.")
    place = arm.names.index(joint)
    # tilted gravity may be stated at any joint; a base is under the first
    bound = effect.everywhere or (effect.whole_arm and not isinstance(effect, RigidBodyEffect))
    if bound and place not in effect.sites(arm.n):
        first = arm.names[effect.sites(arm.n)[0]]
        what = "holds at all joints and is" if effect.everywhere else "is of the whole arm and"
        raise InputError(f"{where}.joints: {effect.label} {what} given once", joint, f"give it at joint {first}")
    if bound and not effect.applies(arm, place):
        raise InputError(f"{where}: {effect.label} is no law for this kind of arm", arm.name, "give another law")
    given = dict(entry.parameters.get(joint, {}))
    _check_values(effect, given, arm.joints[place].kind, f"{where}.parameters.{joint}")
    return Placed(effect, place, given)


def _check_values(effect: Effect, given: Mapping[str, float], kind: str, where: str) -> None:
    known = {parameter.name for parameter in effect.parameters}
    for name in given:
        if name not in known:
            raise InputError(f"{where}.{name} is not a known key", "", f"use one of: {', '.join(sorted(known))}")
    for parameter in effect.parameters:
        value = given.get(parameter.name, parameter.null)
        if not parameter.lower <= value <= parameter.upper and value != parameter.null:
            bounds = with_unit(f"{parameter.lower:g} to {parameter.upper:g}", unit_at(parameter.unit, kind))
            raise InputError(f"{where}.{parameter.name} is out of bounds", f"{value:g}", f"give {bounds}")
    everything = {p.name: given.get(p.name, p.null) for p in effect.parameters}
    if isinstance(effect, SensingEffect) and effect.folds(everything):
        raise InputError(
            f"{where}: such a sensor reads the same at two positions", str(given), "make its waves smaller"
        )
    for parameter in effect.parameters:
        if given and parameter.name not in given and not math.isfinite(parameter.null):
            what, do = f"{where}.{parameter.name} is missing", f"give it: without it there is no {effect.name}"
            raise InputError(what, "", do)


def entries_of(arm: Arm, placed: tuple[Placed, ...]) -> tuple[EffectEntry, ...]:
    """Return placed effects as arm-file entries, effects of one name and law gathered over joints."""
    grouped: dict[tuple[str, str], list[Placed]] = {}
    for place in placed:
        grouped.setdefault((place.effect.name, place.effect.law), []).append(place)
    return tuple(
        EffectEntry(
            name,
            tuple(arm.names[place.joint] for place in places),
            {arm.names[place.joint]: dict(place.values) for place in places},
            law or None,
        )
        for (name, law), places in grouped.items()
    )
