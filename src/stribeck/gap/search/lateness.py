"""Time first: the fraction of a sample, or of a current loop, by which any drive is late, taken up by re-tuning.

A millisecond changes what is left at every joint, and each would otherwise be found as an effect of its own, one after
the other, before what the recordings are about.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from stribeck.effects.registry import effect_named
from stribeck.gap.fitted.model import Model, fit_model, retune, weights_of
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.search.ordinary import is_ordinary
from stribeck.gap.search.rank import rank
from stribeck.model.layout import Placed

LEAST = 1e-4  # s: earlier than that is on time
START = 5e-4  # s
LEAST_T = 2.8  # block-robust t value of what the delays close
EVALUATIONS = 20


def on_time(prepared: Prepared, base: Model, floor: np.ndarray, seed: int, leave_out: Collection[str] = ()) -> Model:
    """Return the re-tuned model, with a delay at each joint whose drive is as late as any drive may be.

    Parameters
    ----------
    prepared : Prepared
    base : Model
        Re-tuned.
    floor : array (n,)
        Noise floor, N m rms.
    seed : int
    leave_out : collection of str
        Effects that no model may have.
    """
    delay = effect_named("delay")
    late = {joint for place in base.placed if place.effect.delays for joint in place.joints(prepared.arm.n)}
    joints = [joint for joint in range(prepared.arm.n) if joint not in late]
    if delay.name in leave_out or not joints:
        return base
    trial = [Placed(delay, joint, {"time": START}) for joint in joints]
    weights = weights_of(base, prepared, floor)
    tried = fit_model(prepared, (*base.placed, *trial), weights, base.fit, evaluations=EVALUATIONS)
    fitted = tried.placed[len(base.placed) :]
    kept = [place for place in fitted if place.values["time"] > LEAST and is_ordinary(place, prepared.scales)]
    if not kept:
        return base
    model = retune(prepared, floor, (*base.placed, *kept))
    lasting = [place for place in model.placed[len(base.placed) :] if place.values["time"] > LEAST]
    if not lasting:
        return base
    if len(lasting) < len(kept):
        model = retune(prepared, floor, (*base.placed, *lasting))
    if not all(is_ordinary(place, prepared.scales) for place in model.placed[len(base.placed) :]):
        return base
    ranking = rank(prepared, [base, model], floor, seed)
    return model if ranking.t[1] > LEAST_T and ranking.overall[1] > 0.0 else base
