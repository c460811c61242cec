"""Whether a law of no library would do better in the place of what the search took."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from joblib import delayed
from numpy.typing import NDArray
from scipy.optimize import minimize

from stribeck.gap.fitted.differentiable import differentiable
from stribeck.gap.fitted.model import Model, cost_by, finite, start_values, weights_of, with_noise
from stribeck.gap.fitted.sizes import effect_scales
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.search.decoys import Decoy, decoys
from stribeck.gap.search.presence import evidence, presence
from stribeck.gap.search.projector import Projector
from stribeck.gap.search.rank import rank
from stribeck.gap.search.step import LookAlike, Step, last_model
from stribeck.identify.absorbed import Absorbed
from stribeck.identify.map_fit import fit
from stribeck.identify.problem import Weights
from stribeck.identify.residual import Residual
from stribeck.model.layout import Placed

Floats = NDArray[np.float64]

HOPEFUL = 0.5  # of the cost that an effect saves: a decoy that promises less is not fitted
MOST = 3  # that are fitted in the place of one effect
EVALUATIONS = 40
MOVES = 90  # trials of other values of what a decoy is not linear in
TELLING = 0.2  # chance from which a decoy is told of


def with_look_alikes(
    prepared: Prepared, steps: Sequence[Step], without: Sequence[Model], pool: Any, seed: int
) -> tuple[Step, ...]:
    """Return the steps with the decoy that comes nearest to what each of them took, where one does.

    Parameters
    ----------
    prepared : Prepared
    steps : sequence of Step
        Of the search.
    without : sequence of Model
        The last model without what each step took (:func:`stribeck.gap.search.beside.without_each`).
    pool : Pool
    seed : int
        Of the bootstrap.
    """
    final, floor = last_model(steps), steps[-1].floor
    weights = weights_of(final, prepared, floor)
    count = len(without)
    places = [_Place(model, (k,)) for k, model in enumerate(without)]
    if count > 1:  # one law outside the library may have been taken for several inside
        places.append(_Place(steps[0].base, tuple(range(count))))
    tries = [
        (place, decoy)
        for place in places
        if finite(place.without)
        for decoy in _hopeful(prepared, place.without, final, weights)
    ]
    fits = pool(delayed(_in_its_place)(prepared, place.without, decoy, weights) for place, decoy in tries)
    nearest: list[LookAlike | None] = [None] * len(steps)
    for (place, decoy), model in zip(tries, fits, strict=True):
        if model is None or not finite(model):
            continue
        alike = LookAlike(decoy.says, float(rank(prepared, [final, model], floor, seed).probability[1]))
        for k in place.steps:
            other = nearest[k]
            nearest[k] = alike if other is None or alike.chance > other.chance else other
    return tuple(replace(step, look_alike=alike) for step, alike in zip(steps, nearest, strict=True))


@dataclass(frozen=True)
class _Place:
    """What decoys are tried in the place of: the model without it, and the steps that took it."""

    without: Model
    steps: tuple[int, ...]


def _hopeful(prepared: Prepared, without: Model, final: Model, weights: Weights) -> list[Decoy]:
    """Return the decoys that may close as much as an effect does, most hopeful first."""
    projector = Projector(without.fit, weights, np.arange(len(without.fit.residual)))
    left = cost_by(final, weights)
    promises = [(_promise(projector, without, decoy, prepared), decoy) for decoy in decoys(prepared.arm)]
    least = HOPEFUL * (projector.cost - left)
    hopeful = [(promise, decoy) for promise, decoy in promises if promise > max(least, 0.0)]
    found: list[Decoy] = []
    for _, decoy in sorted(hopeful, key=lambda pair: -pair[0]):
        if not decoy.form or decoy.form not in {other.form for other in found}:
            found.append(decoy)
    return [_moved(projector, without, decoy, prepared) for decoy in found[:MOST]]


def _moved(projector: Projector, without: Model, decoy: Decoy, prepared: Prepared) -> Decoy:
    """Return a decoy with those values that promise most of what its torque is not linear in."""
    nearby = decoy.nearby
    if nearby is None:
        return decoy
    corners = np.vstack([np.zeros(decoy.bent), np.eye(decoy.bent)])
    found = minimize(
        lambda moved: -_promise(projector, without, nearby(moved), prepared),
        corners[0],
        method="Nelder-Mead",
        options={"initial_simplex": corners, "maxfev": MOVES, "xatol": 0.02, "fatol": 0.5},
    )
    return nearby(found.x)


def _promise(projector: Projector, without: Model, decoy: Decoy, prepared: Prepared) -> float:
    """Return the cost that a decoy saves to first order, everything re-tuned following."""
    columns = _sized(decoy.rows(prepared.fit))
    saved, curvature, slope = projector.step(without.fit.residual, columns)
    ridge = 1e-9 * np.max(np.diag(curvature)) + 1e-12
    return saved + 0.5 * float(slope @ np.linalg.solve(curvature + ridge * np.eye(len(slope)), slope))


def _sized(columns: Floats) -> Floats:
    """Return columns (M, n, K), each of mean square 1."""
    return np.asarray(columns / np.maximum(np.sqrt(np.mean(columns**2, axis=(0, 1))), 1e-300))


def _in_its_place(prepared: Prepared, without: Model, decoy: Decoy, weights: Weights) -> Model | None:
    """Return a model fitted with a decoy; None where one that resists would have to push."""
    path = prepared.path(without.placed)
    columns = decoy.rows(prepared.fit)
    residual = Absorbed(differentiable(path, prepared, prepared.fit), columns, weights.scale)
    start = start_values(path, without.fit, None)
    result = fit(residual, weights, start, effect_scales(path, prepared), evaluations=EVALUATIONS)
    constants = residual.constants(residual.whole.value(result.p)[..., None])[:, 0]
    if decoy.resists and np.any(constants < 0.0):
        return None
    judged = Residual(path, prepared.held, ())
    plain, _ = judged(result.p)
    model = Model(without.placed, result, plain - decoy.rows(prepared.held) @ constants, absorbed=columns.shape[2])
    return with_noise(model, judged, np.concatenate([residual.whole.value(result.p), plain]), prepared)


def told_alike(steps: Sequence[Step], names: Sequence[str]) -> list[str]:
    """Return a warning for each law outside the library that may stand behind what was taken."""
    taken = [step for step in steps if step.taken and step.best is not None]
    told: dict[LookAlike, list[str]] = {}
    for step, place in zip(taken, _last_of(taken), strict=True):
        if step.look_alike is not None and step.look_alike.chance > TELLING:
            told.setdefault(step.look_alike, []).append(f"{place.effect.name} at {names[place.joint]}")
    better = {True: "explains it better", False: "may explain it as well"}
    same = [
        f"{place.effect.name} at {names[0]}: with no joint behind it, {place.effect.alone} is felt just so"
        for place in _last_of(taken)
        if len(names) == 1 and place.effect.alone
    ]
    return same + [
        f"{' and '.join(places)}: {alike.says} {better[alike.chance > 0.5]}, and is no effect of the library"
        for alike, places in told.items()
    ]


def _last_of(steps: Sequence[Step]) -> list[Placed]:
    return [step.best.placed[-1] for step in steps if step.best is not None]


def doubt(steps: Sequence[Step]) -> float:
    """Return the chance that a law outside the library stands behind what was taken."""
    return max(
        (presence(evidence(step)) * step.look_alike.chance for step in steps if step.taken and step.look_alike),
        default=0.0,
    )
