"""Effects that the records show by themselves, before any model: a coarse encoder, a velocity that trails."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stribeck.arm import Arm, unit_at
from stribeck.effects.registry import placed_effects, registry
from stribeck.gap.result import Cause, Estimate
from stribeck.model.layout import Placed
from stribeck.model.values import Record
from stribeck.run import Run


@dataclass(frozen=True)
class Observation:
    """Effects seen in the records: ``placed`` with their values, and ``causes``, one an effect."""

    placed: tuple[Placed, ...]
    causes: tuple[Cause, ...]


def observe(arm: Arm, runs: Sequence[Run], leave_out: Sequence[str] = ()) -> Observation:
    """Return the effects that the records of an arm show directly, those that its file has left out."""
    known = {place.key for place in placed_effects(arm)}
    placed: list[Placed] = []
    causes: list[Cause] = []
    for effect in (effect for effect in registry().values() if effect.direct and effect.name not in leave_out):
        parameters: dict[str, dict[str, Estimate]] = {}
        presence = 0.0
        units = {parameter.name: unit_at(parameter.unit, arm.joints[0].kind) for parameter in effect.parameters}
        for j in effect.sites(arm.n):
            seen = effect.observed(_record(arm, runs, j))
            if seen is None or (effect.name, j) in known:
                continue
            placed.append(Placed(effect, j, {name: value for name, (value, _, _) in seen.values.items()}))
            parameters[arm.names[j]] = {name: Estimate(*v, units[name]) for name, v in seen.values.items()}
            presence = max(presence, seen.probability)
        if parameters:
            nothing = Estimate(0.0, 0.0, 0.0)
            cause = Cause(effect.name, presence, tuple(parameters), (effect.name,), parameters, nothing, presence)
            causes.append(cause)
    return Observation(tuple(placed), tuple(causes))


def _record(arm: Arm, runs: Sequence[Run], j: int) -> Record:
    return Record(
        position=tuple(run.q[:, j] for run in runs),
        velocity=tuple(run.dq[:, j] for run in runs if run.dq is not None) if _all_have_it(runs) else (),
        sample_time=tuple(run.sample_time for run in runs),
        resolution=arm.joints[j].encoder_resolution,
    )


def _all_have_it(runs: Sequence[Run]) -> bool:
    return all(run.dq is not None and bool(np.all(np.isfinite(run.dq))) for run in runs)
