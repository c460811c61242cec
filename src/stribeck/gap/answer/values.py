"""The values of an answer, with their intervals: of the causes, and of what was re-tuned."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stribeck.arm import Arm
from stribeck.gap.answer.margins import widened
from stribeck.gap.answer.nominal import nominal_intervals
from stribeck.gap.fitted.model import Model, weights_of
from stribeck.gap.records.blocks import block_of_rows
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.result import Cause, Estimate, Tuned
from stribeck.identify.confidence import intervals
from stribeck.model.layout import Placed


def parameters_of(cause: Cause, model: Model, prepared: Prepared, floor: np.ndarray) -> dict[str, dict[str, Estimate]]:
    """Return joint -> name -> value of a cause's parameters in a model, at every joint where its law holds.

    Parameters
    ----------
    floor : array (n,)
        Noise floor, N m rms.
    """
    bounds = intervals(model.fit, weights_of(model, prepared, floor), block_of_rows(prepared.fit))
    parameters: dict[str, dict[str, Estimate]] = {}
    for i, entry in enumerate(model.fit.entries):
        place = model.placed[entry.owner] if isinstance(entry.owner, int) else None
        if place is None or place.effect.name != cause.effect:
            continue
        estimate = Estimate(float(model.fit.p[i]), float(bounds.low[i]), float(bounds.high[i]), entry.unit)
        for joint in _joints_of(place, prepared.arm):
            if joint in cause.joints:
                parameters.setdefault(joint, {})[entry.name] = estimate
    step = prepared.fit[0].run.t
    return {joint: widened(own, float(step[1] - step[0])) for joint, own in parameters.items()}


def laws_of(cause: Cause, added: Sequence[Placed], arm: Arm) -> dict[str, str]:
    """Return joint -> law of a named family that has several, as the placed effects have it."""
    laws = [place for place in added if place.effect.name == cause.effect and place.effect.law]
    return {joint: place.effect.law for place in laws for joint in _joints_of(place, arm) if joint in cause.joints}


def _joints_of(place: Placed, arm: Arm) -> list[str]:
    return [arm.names[j] for j in place.joints(arm.n)]


def tuned_of(base: Model, prepared: Prepared, floor: np.ndarray) -> tuple[Tuned, ...]:
    """Return the nominal model's values before and after re-tuning; ``floor`` (n,) is the noise, N m rms."""
    fit, bounds = base.fit, nominal_intervals(base, prepared, floor)
    return tuple(
        Tuned(
            entry.key,
            entry.unit,
            entry.value,
            entry.sd,
            Estimate(float(fit.p[i]), float(bounds.low[i]), float(bounds.high[i]), entry.unit),
            entry.key in fit.at_limit,
            bool(bounds.identified[i]),
        )
        for i, entry in enumerate(fit.entries)
        if entry.owner in ("inertial", "friction")
    )
