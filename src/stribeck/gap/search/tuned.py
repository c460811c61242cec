"""The re-tuned model, from which a search starts, and the noise of every row along it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stribeck.effects.placing import stated_effects
from stribeck.gap.fitted.band import corner_of, rolled_off
from stribeck.gap.fitted.clocks import in_step, without_waves
from stribeck.gap.fitted.model import Model, noise_in_rows, retune
from stribeck.gap.records.floor import noise_of_rows
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.records.spread import Noise
from stribeck.gap.search.lateness import on_time
from stribeck.gap.search.setting import Asked
from stribeck.gap.search.step import Step, last_model
from stribeck.identify.residual import Residual
from stribeck.model.layout import values_of
from stribeck.model.path import SignalPath


@dataclass(frozen=True)
class Retuned:
    """Recordings with the noise of their rows, the model re-tuned to them, and their residual as given (M, n), N m."""

    prepared: Prepared
    given: np.ndarray
    noise: Noise
    base: Model


def retuned(prepared: Prepared, asked: Asked) -> Retuned:
    """Re-tune the nominal model to conditioned recordings, by the band in which that leaves the most to see."""
    asked.progress("re-tuning the nominal model")
    tuned = _retuned(prepared, asked)
    return in_lower_band(tuned, tuned.base, asked) or tuned


def in_lower_band(tuned: Retuned, model: Model, asked: Asked) -> Retuned | None:
    """Return the nominal model re-tuned by a lower band where a model leaves little but noise above that, or None."""
    corner = corner_of(tuned.prepared, model)
    return _retuned(rolled_off(tuned.prepared, corner), asked) if corner < tuned.prepared.fit[0].corner else None


def asks_for_lower(prepared: Prepared, model: Model) -> bool:
    """Return whether a model leaves little but noise in a part of the band in which it counts as much as any."""
    return corner_of(prepared, model) < prepared.fit[0].corner


def lies_above(whole: Prepared, found: Sequence[Step], lower: Prepared, rest: Sequence[Step]) -> bool:
    """Return whether what was found lies above a lower band: nothing is found there, and more than noise left above it.

    Parameters
    ----------
    whole, lower : Prepared
        Recordings by the band in which steps ``found`` were taken, and by the lower one.
    found, rest : sequence of Step
        Of the searches by the one and by the other.
    """
    if not any(step.taken for step in found) or any(step.taken for step in rest):
        return False
    return corner_of(whole, last_model(rest)) > lower.fit[0].corner


def _retuned(prepared: Prepared, asked: Asked) -> Retuned:
    arm = prepared.arm
    own = tuple(place for place in stated_effects(arm) if not place.effect.direct)
    path = SignalPath(arm, own)
    noise = _noise_along(path, values_of(path.entries), prepared, asked.seed)
    base = retune(replace(prepared, noise=noise), noise.rms, own)
    told = in_step(prepared, without_waves(prepared, base))
    if own and told is not prepared:  # one of them may read the clock
        base = retune(replace(told, noise=noise), noise.rms, own)
    prepared = told
    as_given = SignalPath(prepared.file_arm, own)
    given = Residual(as_given, prepared.held, ())(values_of(as_given.entries))[0]
    noise = _noise_along(path, base.fit.p, prepared, asked.seed)
    drawn = noise_in_rows(Residual(path, prepared.held, ()), base.fit.p, base.whole, prepared.moved)
    scales = tuple(replace(scale, noise=low) for scale, low in zip(prepared.scales, noise.rms, strict=True))
    prepared = replace(prepared, noise=replace(noise, drawn=drawn), scales=scales)
    return Retuned(prepared, given, noise, on_time(prepared, base, noise.rms, asked.seed, asked.leave_out))


def _noise_along(path: SignalPath, p: np.ndarray, prepared: Prepared, seed: int) -> Noise:
    fit, held = (
        noise_of_rows(prepared.arm, path, p, runs, prepared.cutoff, seed) for runs in (prepared.fit, prepared.held)
    )
    return Noise(fit, held)
