"""Residuals of models through which noise comes differently, made fit to be compared.

The same encoder and torque noise leaves less in the residual of a model with a compliance: its link does not follow all
that the motor seems to do, and its observer (:mod:`stribeck.model.observer`) takes out what rings. That is no merit of
the law. Each model is judged by its residual over what noise leaves in it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stribeck.gap.model import Model
from stribeck.gap.prepare import Prepared
from stribeck.model.effect import TransmissionEffect


def comparable(prepared: Prepared, models: Sequence[Model], floor: np.ndarray) -> list[np.ndarray]:
    """Return the residuals (M, n) of models on all runs, fitted ones first, N m, as they compare.

    Where some models have a compliance that others lack, theirs are multiplied, joint by joint, by the noise in the
    residual of the first one without it over the noise in their own, the same noise in both.

    Parameters
    ----------
    floor : array (n,)
        Noise floor, N m rms: what it has beyond encoder noise is in the torque.
    """
    plain = [np.concatenate([model.fit.residual, model.held]) for model in models]
    soft = [_soft(model) for model in models]
    shared = set.intersection(*soft)
    stiff = next((model for model, joints in zip(models, soft, strict=True) if joints == shared), models[0])
    own = floor if prepared.noise is None else prepared.noise.rms
    torque = np.sqrt(np.maximum(floor**2 - own**2, 0.0))
    return [
        residual if joints == shared else residual * _ratio(stiff, model, torque)
        for residual, model, joints in zip(plain, models, soft, strict=True)
    ]


def _soft(model: Model) -> set[tuple[str, int]]:
    """Return name and joint of a model's compliances."""
    places = [place for place in model.placed if isinstance(place.effect, TransmissionEffect)]
    return {(place.effect.name, place.joint) for place in places}


def _ratio(stiff: Model, model: Model, torque: np.ndarray) -> np.ndarray:
    """Return the noise in one model's residual over that in another's (n,); 1 where it is not known of both."""
    if stiff.noise is None or model.noise is None:
        return np.ones(len(torque))
    before, after = (np.hypot(encoder, push * torque) for encoder, push in (stiff.noise, model.noise))
    known = np.isfinite(before) & np.isfinite(after) & (before > 0.0) & (after > 0.0)
    return np.asarray(np.where(known, before / np.where(known, after, 1.0), 1.0))
