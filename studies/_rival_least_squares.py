"""Least squares by SciPy on a model with all effects at once, as one would fit "everything that might matter"."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from _rival import CONSTANTS, Answer, friction_intervals
from scipy.optimize import least_squares
from scipy.stats import norm

from stribeck.arm import Arm
from stribeck.gap.model import Model, weights_of
from stribeck.gap.prepare import Prepared
from stribeck.gap.screen import candidates
from stribeck.identify.residual import Residual
from stribeck.model.layout import Entry, Placed
from stribeck.model.path import SignalPath

LITTLE = 0.1  # of an effect's trial value: where a fit of everything starts
EVALUATIONS = 25
HALF = float(norm.ppf(0.975))
FAR = 1e12  # for a bound that there is none
BROKEN = 1e3  # standard deviations, where a law does not compute


def by_least_squares(
    arm: Arm, prepared: Prepared, base: Model, floor: np.ndarray, leave_out: Sequence[str] = ()
) -> Answer:
    """Fit all effects at all joints together, residuals taken for white, and name those whose interval excludes none.

    The exact Jacobian, the arm file's priors and bounds, and the weights are this package's; rows are counted one by
    one. Where two effects exclude each other (two compliances of one joint), the first in the registry is taken; those
    that vanish only in a limit (a stiffness) have no null that an interval could exclude.
    """
    placed: list[Placed] = list(base.placed)
    while more := candidates(arm, placed, leave_out):
        placed.append(Placed(*more[0]))
    path = SignalPath(arm, placed)
    residual = Residual(path, prepared.fit)
    entries = [path.entries[i] for i in residual.columns]
    start, unit = _start(path, prepared, base, residual.columns)
    sd = weights_of(base.fit.residual, prepared, floor).sd
    known = np.array([np.isfinite(entry.sd) for entry in entries])
    nominal = np.array([entry.value if known[k] else 0.0 for k, entry in enumerate(entries)])
    p = np.array([entry.value for entry in path.entries])

    def both(z: np.ndarray) -> tuple[np.ndarray, ...]:
        p[list(residual.columns)] = z * unit
        r, jacobian = residual(p)
        rows, prior = (r / sd).ravel(), (z - nominal / unit)[known]
        columns = (jacobian / sd[None, :, None] * unit).reshape(len(rows), -1)
        stacked = np.concatenate([rows, prior]), np.vstack([columns, np.eye(len(z))[known]])
        return tuple(np.nan_to_num(part, nan=BROKEN, posinf=BROKEN, neginf=-BROKEN) for part in stacked)

    bounds = np.array([(max(e.lower, -FAR), min(e.upper, FAR)) for e in entries]).T / unit
    inside = np.clip(start / unit, bounds[0] + 1e-9, bounds[1] - 1e-9)
    found = least_squares(lambda z: both(z)[0], inside, lambda z: both(z)[1], bounds, max_nfev=EVALUATIONS)
    value, deviation = found.x * unit, np.sqrt(np.diag(np.linalg.pinv(found.jac.T @ found.jac))) * unit
    sure = _surely_there(path, residual.columns, value, deviation)
    at = {entry.key: (value[k], HALF * deviation[k]) for k, entry in enumerate(entries)}
    rows = [at.get(f"{joint}.friction.{name}", (np.nan, None)) for joint in arm.names for name in CONSTANTS]
    ended = "converged" if found.status > 0 else f"not converged in {EVALUATIONS} evaluations"
    named = tuple((placed[k].effect.name, arm.names[placed[k].joint]) for _, k in sure)
    left = np.sqrt(np.mean(found.fun[: base.fit.residual.size] ** 2) / np.mean((base.fit.residual / sd) ** 2))
    says = f"{len(sure)} of {len(placed)} effects significant, {ended}, {left:.0%} of the re-tuned residual left"
    return Answer(named, None, friction_intervals(arm, rows), says)


def _start(
    path: SignalPath, prepared: Prepared, base: Model, columns: tuple[int, ...]
) -> tuple[np.ndarray, np.ndarray]:
    """Return starting values and their units: re-tuned ones, and a little of each effect."""
    tuned = {entry.key: base.fit.p[i] for i, entry in enumerate(base.fit.entries)}
    start, unit = [], []
    for i in columns:
        entry = path.entries[i]
        value = tuned.get(entry.key, entry.value)
        size = entry.sd
        if isinstance(entry.owner, int) and entry.key not in tuned:
            value, size = _little(path.placed[entry.owner], entry, prepared)
        start.append(value)
        unit.append(size if np.isfinite(size) and size > 0.0 else max(abs(value), 1e-3))
    return np.array(start), np.array(unit)


def _little(place: Placed, entry: Entry, prepared: Prepared) -> tuple[float, float]:
    trial = place.effect.starts(prepared.scales[place.joint])[0][entry.name]
    parameter = next(p for p in place.effect.parameters if p.name == entry.name)
    amount = np.isfinite(parameter.null) and not parameter.log and parameter.null in (0.0, 1.0)
    value = parameter.null + LITTLE * (trial - parameter.null) if amount else trial
    return float(value), float(abs(trial - parameter.null) if amount else abs(trial))


def _surely_there(
    path: SignalPath, columns: tuple[int, ...], value: np.ndarray, deviation: np.ndarray
) -> list[tuple[float, int]]:
    """Return (largest |z|, effect) of the effects with a parameter surely off its null, the surest first."""
    best: dict[int, float] = {}
    for k, i in enumerate(columns):
        entry = path.entries[i]
        if isinstance(entry.owner, int):
            null = next(p.null for p in path.placed[entry.owner].effect.parameters if p.name == entry.name)
            z = abs(value[k] - null) / max(deviation[k], 1e-300) if np.isfinite(null) else 0.0
            best[entry.owner] = max(best.get(entry.owner, 0.0), z)
    return sorted(((z, k) for k, z in best.items() if z > HALF), reverse=True)
