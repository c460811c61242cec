"""Least squares by SciPy on a model with all effects at once, as one would fit "everything that might matter"."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from _rival import CONSTANTS, Answer, friction_intervals
from scipy.optimize import least_squares
from scipy.stats import norm

from stribeck.arm import Arm
from stribeck.gap.fitted.model import Model, weights_of
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.search.candidates import candidates
from stribeck.identify.residual import Residual
from stribeck.model.effect import Effect
from stribeck.model.layout import Placed
from stribeck.model.path import SignalPath
from stribeck.model.values import Parameter
from stribeck.model.waves import Trace

LITTLE = 0.01  # of an effect's trial value: where a fit of everything starts
EVALUATIONS = 60
HALF = float(norm.ppf(0.975))
FAR = 1e12  # for a bound that there is none
BROKEN = 1e3  # standard deviations, where a law does not compute
WHERE = ("position", "rest", "harmonic", "frequency", "start")  # parameters that say where or when, not how much


@dataclass(frozen=True)
class Unknowns:
    """Coordinates x (k,) of a fit, their bounds and start, and what they mean: x, 1/x or exp(x) by ``kind`` (k,).

    ``unit`` (k,) is a typical size, ``nominal`` (k,) the centre of a prior of deviation ``unit`` where ``known``, and
    ``null`` (k,) the value without the effect, NaN where that does not ask for one.
    """

    kind: np.ndarray
    start: np.ndarray
    unit: np.ndarray
    low: np.ndarray
    high: np.ndarray
    nominal: np.ndarray
    known: np.ndarray
    null: np.ndarray

    def physical(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return values (k,) and their slopes by z = x / unit."""
        x = z * self.unit
        inverse, logarithm = self.kind == "inverse", self.kind == "log"
        value = np.where(inverse, 1.0 / np.where(inverse, x, 1.0), np.where(logarithm, np.exp(x * logarithm), x))
        return value, np.where(inverse, -(value**2), np.where(logarithm, value, 1.0)) * self.unit


def by_least_squares(
    arm: Arm, prepared: Prepared, base: Model, floor: np.ndarray, leave_out: Sequence[str] = ()
) -> Answer:
    """Fit all effects at all joints together, residuals taken for white, and name those whose interval excludes none.

    It starts from the re-tuned values and a little of each effect, periods where the residual's spectrum is strongest.
    The exact Jacobian, the arm file's priors and bounds, and the weights are this package's; rows are counted one by
    one. A limit is fitted by its inverse, so that it has a null. Laws of compliance (presliding, flexibility, play)
    are left out: along recorded motion a stiff one leaves several times the residual of none, and all of them at once
    would keep the fit from ever coming near that of the model without effects.
    """
    placed: list[Placed] = list(base.placed)
    while more := [place for place in candidates(arm, placed, leave_out) if not _compliance(place[0])]:
        placed.append(Placed(*more[0]))
    path = SignalPath(arm, placed)
    residual = Residual(path, prepared.fit)
    x = unknowns(path, prepared, base, residual.columns)
    sd = weights_of(base, prepared, floor).sd
    p = np.array([entry.value for entry in path.entries])

    def both(z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        p[list(residual.columns)], slope = x.physical(z)
        r, jacobian = residual(p)
        rows, prior = (r / sd).ravel(), (z - x.nominal / x.unit)[x.known]
        columns = (jacobian / sd[..., None] * slope).reshape(len(rows), -1)
        stacked = np.concatenate([rows, prior]), np.vstack([columns, np.eye(len(z))[x.known]])
        value, derivative = (np.nan_to_num(part, nan=BROKEN, posinf=BROKEN, neginf=-BROKEN) for part in stacked)
        return value, derivative

    bounds = np.array([x.low, x.high]) / x.unit
    inside = np.clip(x.start / x.unit, bounds[0] + 1e-9, bounds[1] - 1e-9)
    found = least_squares(lambda z: both(z)[0], inside, lambda z: both(z)[1], bounds, max_nfev=EVALUATIONS)
    deviation = deviations(found.jac)
    z = np.abs(found.x - x.null / x.unit) / np.maximum(deviation, 1e-300)
    sure = _surely_there(path, residual.columns, np.nan_to_num(z))
    value, slope = x.physical(found.x)
    at = {path.entries[i].key: (value[k], HALF * deviation[k] * slope[k]) for k, i in enumerate(residual.columns)}
    rows = [at.get(f"{joint}.friction.{name}", (np.nan, None)) for joint in arm.names for name in CONSTANTS]
    ended = "converged" if found.status > 0 else f"not converged in {EVALUATIONS} evaluations"
    named = tuple((placed[k].effect.name, arm.names[placed[k].joint]) for _, k in sure)
    left = np.sqrt(np.mean(found.fun[: base.fit.residual.size] ** 2) / np.mean((base.fit.residual / sd) ** 2))
    says = f"{len(sure)} of {len(placed)} effects significant, {ended}, {left:.0%} of the re-tuned residual left"
    return Answer(named, None, friction_intervals(arm, rows), says, ended=ended)


def _compliance(effect: Effect) -> bool:
    return any(parameter.name == "stiffness" and not np.isfinite(parameter.null) for parameter in effect.parameters)


def deviations(jacobian: np.ndarray) -> np.ndarray:
    """Return the standard deviations (k,) of coordinates whose residuals are white; large where the data say nothing.

    A pseudo-inverse would call what they say nothing about exact.
    """
    length = np.maximum(np.linalg.norm(jacobian, axis=0), 1e-9)
    scaled = jacobian / length
    return np.asarray(np.sqrt(np.diag(np.linalg.inv(scaled.T @ scaled + 1e-10 * np.eye(len(length))))) / length)


def unknowns(path: SignalPath, prepared: Prepared, base: Model, columns: Sequence[int]) -> Unknowns:
    """Return the coordinates of a fit of all parameters in ``columns``."""
    tuned = {entry.key: float(base.fit.p[i]) for i, entry in enumerate(base.fit.entries)}
    trials = [_trial(place, prepared, base) for place in path.placed]
    rows = []
    for i in columns:
        entry = path.entries[i]
        low, high = max(entry.lower, -FAR), min(entry.upper, FAR)
        if isinstance(entry.owner, int) and entry.key not in tuned:
            parameter = next(q for q in path.placed[entry.owner].effect.parameters if q.name == entry.name)
            rows.append((*_of_effect(parameter, trials[entry.owner], low, high), np.nan, False))
        else:
            value, known = tuned.get(entry.key, entry.value), bool(np.isfinite(entry.sd))
            size = entry.sd if known else max(abs(value), 1e-3)
            rows.append(("plain", value, size, low, high, np.nan, entry.value if known else 0.0, known))
    kind, start, unit, low_, high_, null, nominal, known_ = (np.array(part) for part in zip(*rows, strict=True))
    return Unknowns(kind, start, unit, low_, high_, np.nan_to_num(nominal), known_, null)


def _trial(place: Placed, prepared: Prepared, base: Model) -> dict[str, float]:
    j = place.joint

    def column(name: str) -> np.ndarray:
        parts = [getattr(run, name)[run.analysis_index] for run in prepared.fit]
        return np.concatenate([part if part.ndim == 1 else part[:, j] for part in parts])

    signals = {name: column(name) for name in ("time", "position", "velocity", "command")}
    return dict(place.effect.starts_from(prepared.scales[j], Trace(**signals, residual=base.fit.residual[:, j]))[0])


def _of_effect(
    parameter: Parameter, trial: dict[str, float], low: float, high: float
) -> tuple[str, float, float, float, float, float]:
    """Return kind, start, unit, bounds and null of an effect's parameter."""
    value, null = trial[parameter.name], parameter.null
    if not np.isfinite(null):
        return "inverse", LITTLE / value, 1.0 / value, 1.0 / high, 1.0 / low, 0.0
    if parameter.log:
        return "log", float(np.log(value)), 1.0, float(np.log(low)), float(np.log(high)), np.nan
    size = max(abs(value - null), 1e-3)
    if parameter.name in WHERE:
        return "plain", value, max(abs(value), 1e-3), low, high, np.nan
    return "plain", null + LITTLE * (value - null), size, low, high, null


def _surely_there(path: SignalPath, columns: tuple[int, ...], z: np.ndarray) -> list[tuple[float, int]]:
    """Return (largest |z|, effect) of the effects with a parameter surely off its null, the surest first."""
    best: dict[int, float] = {}
    for k, i in enumerate(columns):
        owner = path.entries[i].owner
        if isinstance(owner, int):
            best[owner] = max(best.get(owner, 0.0), float(z[k]))
    return sorted(((value, k) for k, value in best.items() if value > HALF), reverse=True)
