"""Other effects in the place of one that was taken, screened anew beside all the others."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stribeck.gap.fitted.model import Model, finite
from stribeck.gap.search.families import best_laws
from stribeck.gap.search.instead import Instead, in_its_place
from stribeck.gap.search.rank import ALIKE
from stribeck.gap.search.setting import Setting
from stribeck.gap.search.step import Step, last_model
from stribeck.gap.search.tryout import Tryout
from stribeck.model.layout import Placed

MOST = 3  # effects that are fitted in the place of one


def swapped(setting: Setting, steps: Sequence[Step], without: Sequence[Model]) -> list[Instead]:
    """Return the last model with what promises as much as an effect in its place, now that the others are there.

    The step that took it may not have seen that: a gain that was still hidden changes what an offset looks like. Of the
    effects at its joint, those that are linear and those that came near in its step: nonlinear ones take long. Not in
    the place of the last one, beside which its step has seen them all.

    Parameters
    ----------
    setting : Setting
    steps : sequence of Step
        Of the search.
    without : sequence of Model
        As of :func:`stribeck.gap.search.beside.without_each`.
    """
    own, taken = len(steps[0].base.placed), [step for step in steps if step.taken]
    found: list[tuple[Placed, Placed]] = []
    for place, step, rest in zip(last_model(steps).placed[own:], taken[:-1], without, strict=False):
        if not finite(rest):
            continue
        seen = step.ends
        tryout = Tryout(setting, rest, dict(seen))
        every = {(effect.name, effect.law, joint): effect for effect, joint in tryout.possible if joint == place.joint}
        here = {key for key, effect in every.items() if key in seen or not effect.nonlinear}
        trials = [trial for trial in best_laws(tryout.screened(here)) if np.isfinite(trial.promise)]
        least = ALIKE * max((trial.promise for trial in trials if trial.key == place.key), default=np.inf)
        others = sorted((t for t in trials if t.key != place.key and t.promise > least), key=lambda t: -t.promise)
        found += [(place, Placed(trial.effect, trial.joint, trial.start)) for trial in others[:MOST]]
    return in_its_place(setting.prepared, steps, found, setting.pool)
