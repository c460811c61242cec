"""Effects that the records show by themselves, before any model: a coarse encoder, a velocity that trails."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stribeck.arm import Arm, unit_at
from stribeck.effects.placing import stated_effects
from stribeck.effects.registry import registry
from stribeck.gap.records.usual import no_more_than_any
from stribeck.gap.result import Cause, Estimate
from stribeck.grid import uniform
from stribeck.identify.stretches import between_gaps
from stribeck.model.layout import Placed
from stribeck.model.scale import Scale
from stribeck.model.values import Observed, Record
from stribeck.run import Run
from stribeck.run.reading import as_read

FAR = 0.3  # of what is seen: the arm file's value is another one


@dataclass(frozen=True)
class Observation:
    """Effects seen in the records: ``placed`` with their values, and ``causes``, one an effect; ``notes`` on others."""

    placed: tuple[Placed, ...]
    causes: tuple[Cause, ...]
    notes: tuple[str, ...] = ()


def observe(arm: Arm, runs: Sequence[Run], scales: Sequence[Scale], *, leave_out: Sequence[str] = ()) -> Observation:
    """Return the effects that the records of an arm show directly, those that its file has left out.

    What every arm has some of is told in a note, where all joints have it: at one of several it is no habit of drives.
    """
    read = [as_read(run)[0] for run in runs]
    runs = between_gaps([uniform(run)[0] for run in runs], [])
    known = {place.key: place for place in stated_effects(arm)}
    placed: list[Placed] = []
    causes: list[Cause] = []
    notes: list[str] = []
    for effect in (effect for effect in registry().values() if effect.direct and effect.name not in leave_out):
        units = {parameter.name: unit_at(parameter.unit, arm.joints[0].kind) for parameter in effect.parameters}
        records = {j: _record(arm, read, runs, j) for j in effect.sites(arm.n)}
        seen = {j: found for j, record in records.items() if (found := effect.observed(record)) is not None}
        here = [Placed(effect, j, {name: value for name, (value, _, _) in seen[j].values.items()}) for j in seen]
        habit = len(here) == arm.n and all(effect.ordinary(place.values, scales[place.joint]) for place in here)
        notes += [text for j, found in seen.items() for text in _unlike(arm, known.get((effect.name, j)), found)]
        here = [place for place in here if place.key not in known]
        if habit:
            notes += [f"{arm.names[place.joint]}: {no_more_than_any(place, arm)}" for place in here]
        elif here:
            placed += here
            parameters = {
                arm.names[place.joint]: {n: Estimate(*v, units[n]) for n, v in seen[place.joint].values.items()}
                for place in here
            }
            presence = max(seen[place.joint].probability for place in here)
            nothing = Estimate(0.0, 0.0, 0.0)
            cause = Cause(effect.name, presence, tuple(parameters), (effect.name,), parameters, nothing, presence)
            causes.append(cause)
    return Observation(tuple(placed), tuple(causes), tuple(notes))


def _unlike(arm: Arm, stated: Placed | None, seen: Observed) -> list[str]:
    """Return a note on each value that the records surely show to be another than the arm file has."""
    values = stated.values if stated else {}
    return [
        f"{arm.names[stated.joint]}: {stated.effect.name} has {name} {value:.3g} by the records, "
        f"{values[name]:.3g} in the arm file; this is what corrected.toml keeps"
        for name, (value, low, high) in seen.values.items()
        if stated and name in values and not low <= values[name] <= high and abs(value - values[name]) > FAR * value
    ]


def _record(arm: Arm, read: Sequence[Run], runs: Sequence[Run], j: int) -> Record:
    return Record(
        position=tuple(run.q[:, j] for run in runs),
        velocity=tuple(run.dq[:, j] for run in runs if run.dq is not None) if _all_have_it(runs) else (),
        sample_time=tuple(run.sample_time for run in runs),
        resolution=arm.joints[j].encoder_resolution,
        read=tuple(run.q[:, j] for run in read),
        prismatic=arm.joints[j].kind == "prismatic",
    )


def _all_have_it(runs: Sequence[Run]) -> bool:
    return all(run.dq is not None and bool(np.all(np.isfinite(run.dq))) for run in runs)
