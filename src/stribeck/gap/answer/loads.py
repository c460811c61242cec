"""Recordings of which some carry a load at the tip: one arm in each, and another one in all of them together.

An arm that picks and places is recorded with and without. Fitted to all, masses lie in between, and what is left of
each recording is the torque of a mass at the tip, of either sign.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stribeck.effects.registry import effect_named
from stribeck.gap.answer.each_recording import NOTHING, recording_of_rows, slope_of_each
from stribeck.gap.fitted.model import Model, start_values
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.records.spread import noise_power, spread
from stribeck.identify.blocks import block_of_rows
from stribeck.identify.residual import Residual
from stribeck.model.layout import Placed
from stribeck.model.path import SignalPath

LOAD = "payload"
LEAST = 3  # recordings
MOSTLY = 0.3  # of the squares that one mass leaves, which a mass of each recording's own must explain
SURE = 5.0  # standard errors between the two groups
ALIKE = 0.25  # of the range of masses, by which those of a group may differ


def told_loads(prepared: Prepared, models: Sequence[Model], floor: np.ndarray) -> list[str]:
    """Return a warning where recordings fall in two groups, by a mass at the tip, by the first model that shows it.

    Parameters
    ----------
    prepared : Prepared
    models : sequence of Model
        Fitted to its recordings.
    floor : array (n,)
        Noise floor, N m rms.
    """
    names = list(dict.fromkeys(run.name for run in (*prepared.fit, *prepared.held)))
    for model in models if len(names) >= LEAST else ():
        mass, error, share = _masses(prepared, model, floor, names)
        above = (mass - mass.min()) / max(float(np.ptp(mass)), NOTHING)
        light, heavy = above < ALIKE, above > 1.0 - ALIKE
        if share < MOSTLY or not heavy.any() or not np.all(light | heavy):
            continue
        if mass[heavy].min() - mass[light].max() < SURE * np.hypot(error[heavy].max(), error[light].max()):
            continue
        which = ", ".join(sorted(name for name, one in zip(names, heavy, strict=True) if one))
        more = np.mean(mass[heavy]) - np.mean(mass[light])
        return [
            f"{which}: as with {more:.2g} kg more at the tip than in the other recordings; if they carry a load, "
            "diagnose those with and those without it apart"
        ]
    return []


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
