"""Residuals of models through which noise comes differently, made fit to be compared.

The same encoder and torque noise leaves less in the residual of a model with a compliance: its link does not follow all
that the motor seems to do, and its observer (:mod:`stribeck.model.observer`) takes out what rings, and a part of any
other torque besides. That is no merit of the law: what a model takes is put back before it is compared.
"""

from __future__ import annotations

import numpy as np
from scipy.fft import dct, idct

from stribeck.gap.records.passed import Passed
from stribeck.gap.records.prepare import Prepared

NOISE_TO = 2.0  # of a model's own noise, squared: what is left up to there may be noise that is underrated


def quieter(prepared: Prepared, noise: Passed | None, floor: np.ndarray) -> np.ndarray:
    """Return the noise in a model's residual over that in the re-tuned model's (n,); at most 1, and 1 where not known.

    Parameters
    ----------
    prepared : Prepared
    noise : Passed or None
        What noise adds to the model's residual.
    floor : array (n,)
        Noise floor of the re-tuned model, N m rms: what it has beyond encoder noise is in the torque.
    """
    if noise is None or prepared.reference is None:
        return np.ones(len(floor))
    own = floor if prepared.noise is None else prepared.noise.rms
    torque = np.sqrt(np.maximum(floor**2 - own**2, 0.0))
    here, there = (np.hypot(of.encoder, of.torque * torque) for of in (noise, prepared.reference))
    known = noise.known(prepared.reference) & (here > 0.0) & (there > 0.0)
    return np.asarray(np.where(known, np.minimum(here / np.where(known, there, 1.0), 1.0), 1.0))


def put_back(prepared: Prepared, residual: np.ndarray, noise: Passed | None, floor: np.ndarray) -> np.ndarray:
    """Return a model's residual (M, n), N m, as it would be had the model left in it all that it takes of any torque.

    Where no more is left than noise, all of a joint's rows are multiplied, as the noise is; what is more has its
    spectrum restored, run by run, as a torque has it that no model foretells.

    Parameters
    ----------
    prepared : Prepared
    residual : array (M, n)
        On all runs, fitted ones first.
    noise, floor : Passed or None, array
        As of :func:`quieter`.
    """
    if noise is None or prepared.reference is None:
        return residual
    part = quieter(prepared, noise, floor)
    power = np.mean(residual**2, axis=0)
    taken = np.minimum(NOISE_TO * (part * floor) ** 2 / np.maximum(power, 1e-300), 1.0)
    edges = np.cumsum([len(run.analysis_index) for run in (*prepared.fit, *prepared.held)])[:-1]
    whole = []
    for rows in np.split(residual, edges):
        times = np.sqrt(taken / part**2 + (1.0 - taken) / noise.part_of(prepared.reference, len(rows)))
        whole.append(idct(times * dct(rows, axis=0), axis=0))
    return np.concatenate(whole)
