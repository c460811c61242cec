"""The band by which models are compared: where the encoder's noise outweighs what they leave, it counts for less.

Differentiated twice, that noise rises with the square of the frequency, and most of it lies just below the cutoff; what
a model lacks mostly lies far below. Squares of a residual that holds both tell little of the latter. Rolled off from
where noise alone is left, it is about as strong at all frequencies, as least squares want it (Aitken 1936).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy import signal

from stribeck.gap.fitted.model import Model
from stribeck.gap.records.prepare import Prepared
from stribeck.identify.conditioning import Conditioned
from stribeck.identify.residual import Residual
from stribeck.model.path import SignalPath

CORNERS = (0.35, 0.5, 0.7, 1.0)  # of the cutoff: the band may roll off from one of the first three on
MOSTLY = 3.0  # of the power of the encoder's noise, up to which a part of the band holds little else
FEWEST = 32  # samples of a recording, of which a spectrum tells


def corner_of(prepared: Prepared, model: Model) -> float:
    """Return the frequency, Hz, from which a model leaves little but the encoder's noise at every joint.

    Infinite where it leaves more up to the cutoff, or all recordings are too short for a spectrum.
    """
    runs = (*prepared.fit, *prepared.held)
    if all(len(run.analysis_index) < FEWEST for run in runs):
        return math.inf
    residual = Residual(SignalPath(prepared.arm, model.placed), runs, ())
    left = residual.value(model.fit.p)
    noise = residual.along(prepared.moved).value(model.fit.p) - left
    edges = prepared.cutoff * np.array(CORNERS)
    loud = np.flatnonzero(~np.all(_power(left, runs, edges) <= MOSTLY * _power(noise, runs, edges), axis=1))
    first = int(loud[-1]) + 1 if len(loud) else 0
    return math.inf if first == len(edges) - 1 else float(edges[first])


def rolled_off(prepared: Prepared, corner: float) -> Prepared:
    """Return recordings whose analysis filter is rolled off from a corner on, Hz, without what noise leaves there."""
    fit, held = (tuple(run.rolled_off(corner) for run in part) for part in (prepared.fit, prepared.held))
    return replace(prepared, fit=fit, held=held, noise=None, reference=None)


def band_of(prepared: Prepared) -> dict[str, float]:
    """Return the cutoff, Hz, and the corner where there is one, by the names that they have in ``diagnosis.json``."""
    corner = prepared.fit[0].corner
    return {"cutoff_hz": prepared.cutoff, **({"corner_hz": corner} if math.isfinite(corner) else {})}


def told_band(prepared: Prepared) -> list[str]:
    """Return a note on where the band rolls off."""
    corner = prepared.fit[0].corner
    if math.isinf(corner):
        return []
    return [f"rolled off from {corner:.3g} Hz on, above which little but the encoder's noise is left"]


def _power(residual: np.ndarray, runs: Sequence[Conditioned], edges: np.ndarray) -> np.ndarray:
    """Return the squares (K, n) of a residual (M, n) between each two of the edges, Hz, their sum, N^2 m^2."""
    power = np.zeros((len(edges) - 1, residual.shape[1]))
    start = 0
    for run in runs:
        part = residual[start : start + len(run.analysis_index)]
        start += len(part)
        if len(part) < FEWEST:
            continue
        rate = 1.0 / (run.sample_time * run.decimation)
        frequency, density = signal.periodogram(part, rate, "hann", axis=0)
        which = np.searchsorted(edges, frequency, side="right") - 1
        for k in range(len(power)):
            power[k] += rate * np.sum(density[which == k], axis=0)
    return power
