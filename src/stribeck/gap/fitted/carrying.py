"""Recordings of which some carry a load at the tip: one arm in each, and another one in all of them together.

An arm that picks and places is recorded with and without. Fitted to all, masses lie in between, and what is left of
each recording is the torque of a mass at the tip, of either sign.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stribeck.effects.registry import effect_named
from stribeck.gap.fitted.model import Model, start_values
from stribeck.gap.records.each_recording import NOTHING, recording_of_rows, slope_of_each
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.records.spread import noise_power, spread
from stribeck.identify.blocks import block_of_rows
from stribeck.identify.conditioning import Conditioned
from stribeck.identify.residual import Residual
from stribeck.model.layout import Placed
from stribeck.model.path import SignalPath

LOAD = "payload"
LEAST = 3  # recordings
MOSTLY = 0.3  # of the squares that one mass leaves, which a mass of each recording's own must explain
SURE = 5.0  # standard errors between the two groups
ALIKE = 0.25  # of the range of masses, by which those of a group may differ


@dataclass(frozen=True)
class Carrying:
    """The names of recordings as if ``loaded`` with so much ``more`` at the tip, kg, than the ``unloaded`` ones."""

    loaded: tuple[str, ...]
    unloaded: tuple[str, ...]
    more: float


def carrying(prepared: Prepared, model: Model, floor: np.ndarray) -> Carrying | None:
    """Return which recordings carry a load that the others do not, None where they do not fall in two such groups.

    Parameters
    ----------
    prepared : Prepared
    model : Model
        Fitted to its recordings.
    floor : array (n,)
        Noise floor, N m rms.
    """
    prepared = _with_load(prepared, ())
    names = list(dict.fromkeys(run.name for run in (*prepared.fit, *prepared.held)))
    if len(names) < LEAST:
        return None
    mass, error, share = _masses(prepared, model, floor, names)
    above = (mass - mass.min()) / max(float(np.ptp(mass)), NOTHING)
    light, heavy = above < ALIKE, above > 1.0 - ALIKE
    if share < MOSTLY or not heavy.any() or not np.all(light | heavy):
        return None
    if mass[heavy].min() - mass[light].max() < SURE * np.hypot(error[heavy].max(), error[light].max()):
        return None
    loaded, unloaded = ([name for name, its in zip(names, kind, strict=True) if its] for kind in (heavy, light))
    return Carrying(tuple(sorted(loaded)), tuple(unloaded), float(np.mean(mass[heavy]) - np.mean(mass[light])))


def told_apart(prepared: Prepared, found: Carrying) -> Prepared:
    """Return recordings of which the unloaded ones are without a payload, whatever the model has.

    Where some of each kind are fitted: else no fit tells its mass from that of the last link.
    """
    fitted = {run.name for run in prepared.fit}
    both = fitted & set(found.loaded) and fitted & set(found.unloaded)
    return _with_load(prepared, found.unloaded) if both else prepared


def unloaded(prepared: Prepared) -> tuple[str, ...]:
    """Return the names of recordings that are without a payload that others carry."""
    return tuple(dict.fromkeys(run.name for run in (*prepared.fit, *prepared.held) if LOAD in run.without))


def _with_load(prepared: Prepared, names: Sequence[str]) -> Prepared:
    """Return recordings of which those of some names are without a payload."""

    def told(runs: Sequence[Conditioned]) -> tuple[Conditioned, ...]:
        return tuple(replace(run, without=frozenset({LOAD}) if run.name in names else frozenset()) for run in runs)

    return replace(prepared, fit=told(prepared.fit), held=told(prepared.held))


def _masses(
    prepared: Prepared, model: Model, floor: np.ndarray, names: Sequence[str]
) -> tuple[np.ndarray, np.ndarray, float]:
    """Return each recording's mass at the tip beyond the model's, kg, its block-robust standard error, and the share.

    Arrays (R,); the share is of the squares that the best mass of all recordings leaves.
    """
    runs, whole = (*prepared.fit, *prepared.held), model.whole
    sd = spread(whole, noise_power(prepared.noise, floor, len(whole), model.rows))
    change = _per_mass(prepared, model)
    left, change = ((each / sd).reshape(-1, 1) for each in (whole, change))  # one mass for all joints
    of_row, block = (np.repeat(each, whole.shape[1]) for each in (recording_of_rows(runs, names), block_of_rows(runs)))
    mass, error, rest = slope_of_each(left, change, of_row, block)
    common = -np.sum(left * change) / max(float(np.sum(change**2)), NOTHING)
    return mass[:, 0], error[:, 0], 1.0 - float(np.sum(rest**2) / np.sum((left + common * change) ** 2))


def _per_mass(prepared: Prepared, model: Model) -> np.ndarray:
    """Return what a mass at the tip adds to the residual (M, n) on all recordings, N m/kg."""
    tip = len(prepared.arm.joints) - 1
    load = Placed(effect_named(LOAD), tip, {"mass": 0.0})
    placed = model.placed if any(place.key == load.key for place in model.placed) else (*model.placed, load)
    path = SignalPath(prepared.arm, placed)
    p = start_values(path, model.fit, None)
    owner = next(k for k, place in enumerate(path.placed) if place.key == load.key)
    step = 0.01 * (sum(joint.mass for joint in prepared.arm.joints) or 1.0)
    more = p + step * np.array([(entry.owner, entry.name) == (owner, "mass") for entry in path.entries])
    residual = Residual(path, (*prepared.fit, *prepared.held), ())
    return np.asarray((residual.value(more) - residual.value(p)) / step)
