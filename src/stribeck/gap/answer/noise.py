"""The noise floor of an answer: what noise leaves in the model that is delivered, not in one that lacks its effects.

A gap makes noise look larger than it is: filters round off whatever is sharp in it, and friction that is wrong turns
the signs of velocities at other moments.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stribeck.gap.fitted.model import Model
from stribeck.gap.fitted.noisy import quieter
from stribeck.gap.fitted.white import noise_of_best
from stribeck.gap.records.floor import noise_of_rows
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.records.spread import Noise
from stribeck.gap.result import RandomTorque
from stribeck.gap.search.random_torque import added_power, random_torque
from stribeck.model.path import SignalPath


@dataclass(frozen=True)
class Heard:
    """What no model closes on the held-out runs: ``rows`` (K, n), and as a root mean square the ``floor`` (n,), N m.

    ``random`` is what of it is torque that knows nothing of the motion, ``prepared`` the recordings with the rest.
    """

    prepared: Prepared
    rows: np.ndarray
    floor: np.ndarray
    random: tuple[RandomTorque, ...]


def heard(prepared: Prepared, model: Model, rows: np.ndarray, floor: np.ndarray, seed: int) -> Heard:
    """Return the noise with what a model leaves that is random: no model can close that either.

    Parameters
    ----------
    prepared : Prepared
    model : Model
    rows, floor : array (K, n), (n,)
        What encoder noise, filters and white torque leave, N m.
    seed : int
        Of the draws that tell whether it is random.
    """
    random = random_torque(prepared, model, floor, seed)
    more = added_power(random, prepared.arm.names)
    return Heard(prepared, np.sqrt(rows**2 + more), np.sqrt(floor**2 + more), random)


def heard_through(prepared: Prepared, chain: Sequence[Model], floor: np.ndarray, seed: int) -> Heard:
    """Return the noise along the last of a chain of models, at each joint where it is less than the re-tuned model's.

    Parameters
    ----------
    prepared : Prepared
        With the noise of its rows along the re-tuned model.
    chain : sequence of Model
        The re-tuned one, then one named effect more each.
    floor : array (n,)
        By which the search judged, N m rms: no more than that is noise.
    seed : int
        Of the noise that is drawn, and of the bootstrap.
    """
    last, before = chain[-1], prepared.noise
    assert before is not None
    path, part = SignalPath(prepared.arm, last.placed), quieter(prepared, last.noise, floor)
    fit, held = (
        noise_of_rows(prepared.arm, path, last.fit.p, runs, prepared.cutoff, seed) / part
        for runs in (prepared.fit, prepared.held)
    )
    less = Noise(fit, held).rms < before.rms
    noise = Noise(np.where(less, fit, before.fit), np.where(less, held, before.held))
    prepared = replace(prepared, noise=noise)
    floor = np.minimum(noise_of_best(noise.rms, chain, prepared), floor)
    rows = np.sqrt(noise.held**2 + np.maximum(floor**2 - noise.rms**2, 0.0))
    return heard(prepared, last, rows, floor, seed)
