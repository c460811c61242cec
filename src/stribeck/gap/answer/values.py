"""The values of an answer, with their intervals: of the causes, and of what was re-tuned."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from stribeck.arm import Arm
from stribeck.effects.placing import stated_effects
from stribeck.gap.answer.margins import widened
from stribeck.gap.answer.nominal import nominal_intervals
from stribeck.gap.fitted.model import Model, weights_of
from stribeck.gap.fitted.sizes import effect_scales
from stribeck.gap.records.blocks import block_of_rows
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.result import Cause, Estimate, Tuned
from stribeck.identify.confidence import intervals
from stribeck.model.layout import Placed, layout
from stribeck.model.path import SignalPath

FAR = 0.3  # of an effect's size in the arm file: three times what a mass is known to where the file says nothing


def parameters_of(cause: Cause, model: Model, prepared: Prepared, floor: np.ndarray) -> dict[str, dict[str, Estimate]]:
    """Return joint -> name -> value of a cause's parameters in a model, at every joint where its law holds.

    Parameters
    ----------
    cause : Cause
    model : Model
        That holds the effect.
    prepared : Prepared
    floor : array (n,)
        Noise floor, N m rms.
    """
    bounds = intervals(model.fit, weights_of(model, prepared, floor), block_of_rows(prepared.fit))
    parameters: dict[str, dict[str, Estimate]] = {}
    limits: dict[str, dict[str, tuple[float, float]]] = {}
    for i, entry in enumerate(model.fit.entries):
        place = model.placed[entry.owner] if isinstance(entry.owner, int) else None
        if place is None or place.effect.name != cause.effect:
            continue
        estimate = Estimate(float(model.fit.p[i]), float(bounds.low[i]), float(bounds.high[i]), entry.unit)
        for joint in _joints_of(place, prepared.arm):
            if joint in cause.joints:
                parameters.setdefault(joint, {})[entry.name] = estimate
                limits.setdefault(joint, {})[entry.name] = entry.lower, entry.upper
    step = prepared.scales[0].sample_time
    return {joint: widened(own, limits[joint], step) for joint, own in parameters.items()}


def laws_of(cause: Cause, added: Sequence[Placed], arm: Arm) -> dict[str, str]:
    """Return joint -> law of a named family that has several, as the placed effects have it."""
    laws = [place for place in added if place.effect.name == cause.effect and place.effect.law]
    return {joint: place.effect.law for place in laws for joint in _joints_of(place, arm) if joint in cause.joints}


def _joints_of(place: Placed, arm: Arm) -> list[str]:
    return [arm.names[j] for j in place.joints(arm.n)]


def tuned_of(model: Model, prepared: Prepared, floor: np.ndarray) -> tuple[Tuned, ...]:
    """Return the arm file's values before and after a fit, those of its effects last.

    Parameters
    ----------
    model : Model
        The re-tuned one, or that with the named effects.
    prepared : Prepared
    floor : array (n,)
        Noise floor, N m rms.
    """
    fit, bounds = model.fit, nominal_intervals(model, prepared, floor)
    found = {
        entry.key: Estimate(float(fit.p[i]), float(bounds.low[i]), float(bounds.high[i]), entry.unit)
        for i, entry in enumerate(fit.entries)
    }
    nominal = [
        Tuned(entry.key, entry.unit, entry.value, entry.sd, found[entry.key], entry.key in fit.at_limit, bool(sure))
        for entry, sure in zip(fit.entries, bounds.identified, strict=True)
        if entry.owner in ("inertial", "friction")
    ]
    return (*nominal, *_of_effects(model, prepared, found))


def _of_effects(model: Model, prepared: Prepared, found: Mapping[str, Estimate]) -> Iterator[Tuned]:
    """Yield the values of the arm file's own effects, those by key that were ``found`` with the intervals of the fit.

    They have no tolerance: whether one has moved far is told by its effect's size in the file, or a typical one.
    """
    arm, step = prepared.arm, prepared.scales[0].sample_time
    stated = {entry.key: entry.value for entry in layout(arm, stated_effects(arm))}
    typical = effect_scales(SignalPath(arm, model.placed), prepared)
    for k in range(len(model.placed)):  # what re-tuning took in beside them is told in a note
        own = [entry for entry in model.fit.entries if entry.owner == k and entry.key in stated]
        limits = {entry.name: (entry.lower, entry.upper) for entry in own}
        values = widened({entry.name: found[entry.key] for entry in own}, limits, step)
        for entry in own:
            value, nominal = values[entry.name], stated[entry.key]
            size = math.hypot(*(stated[other.key] for other in own if other.unit == entry.unit)) or typical[entry.key]
            moved = abs(value.value - nominal) > FAR * size and not value.low <= nominal <= value.high
            yield Tuned(entry.key, entry.unit, nominal, math.inf, value, moved=moved)
