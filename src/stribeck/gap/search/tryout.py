"""The candidates beside one base model, screened and fitted."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from itertools import compress
from typing import NamedTuple

import numpy as np
from joblib import delayed

from stribeck.gap.fitted.model import Bristled, Model, finite, fit_model, start_values, weights_of
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.search.candidates import Trial, candidates
from stribeck.gap.search.families import left_by
from stribeck.gap.search.gates import LEAST_GAIN
from stribeck.gap.search.screen import screen
from stribeck.gap.search.setting import Known, Setting
from stribeck.gap.search.starts import ends, from_every_start, meant
from stribeck.identify.problem import Weights
from stribeck.identify.residual import Residual
from stribeck.model.effect import TransmissionEffect
from stribeck.model.layout import Placed
from stribeck.model.path import SignalPath

RELIEVED = 0.85  # of a joint's residual: an effect that leaves less is fitted once more, with weights of its own
AGAIN = 8  # times at most
SHORT = 0.5  # of what screening promised: a fit that was stopped and has found less goes on
LONGER = 80  # evaluations, from where it is, or from where the effect is none
AS_MUCH = 0.85  # of what was left at a joint, or so much less: else a compliance may have been hidden by what is gone
LEAST_DAMPED = 0.03  # of the damping at which a play's fit ends, from which it is started once more
BETWEEN = (1.47, 0.68)  # of the room that a play's fit ends at: halfway to its next starts
MUCH = 2.0  # noise floors rms that it leaves: it may stand in a valley beside the right one's
NEAR = 0.75  # of the cost without it, to which it must have come to be a play at all
MEANT = 0.2  # of a joint's cost promised by a law that ends in a corner where it cannot be meant: it starts elsewhere


class Tryout:
    """What can be added to a base model: each law is screened once, and fitted once, however often it is asked for.

    Parameters
    ----------
    setting : Setting
    base : Model
        Is fitted anew, with weights of its own; it stays as it is where that runs away.
    known : dict
        Values that laws came to in screening before; those of this one are added.

    Attributes
    ----------
    base : Model
    possible : list of (Effect, int)
        Laws and joints that could be added.
    cost : array (n,)
        What each joint's residual costs without them, counted as in screening.
    """

    def __init__(self, setting: Setting, base: Model, known: Known) -> None:
        self._setting, self._known = setting, known
        self._weights = weights_of(base, setting.prepared, setting.floor)
        anew = fit_model(setting.prepared, base.placed, self._weights, base.fit)
        self.base = anew if finite(anew) else base  # by other weights it may run away where it is judged
        every = candidates(setting.prepared.arm, self.base.placed, setting.leave_out)
        self.possible = [(effect, joint) for effect, joint in every if (effect.name, joint) not in setting.barred]
        # a joint with a slow gap has few independent rows; counted joint by joint, another's noise would outbid it
        correlation = self._weights.correlation
        self._even = replace(self._weights, correlation=np.full_like(correlation, correlation.max()))
        self.cost = 0.5 * np.sum((self.base.fit.residual * self._even.scale) ** 2, axis=0)
        self._states = _states(setting.prepared, self.base)
        self._trials: dict[tuple[str, str, int], Trial] = {}
        self._models: dict[tuple[str, str, int], Model | None] = {}

    def screened(self, among: Collection[tuple[str, str, int]] | None = None) -> list[Trial]:
        """Return a trial of every possible law, or of some of them by name, law and joint."""
        prepared, base, known = self._setting.prepared, self.base, self._known
        every = {(effect.name, effect.law, joint): (effect, joint) for effect, joint in self.possible}
        wanted = every if among is None else {key: place for key, place in every.items() if key in among}
        new = [key for key in wanted if key not in self._trials]
        places = len({(name, joint) for name, _, joint in new})
        self._setting.progress(f"screening {places} candidates, {len(new)} laws")
        trials = self._setting.pool(
            delayed(screen)(prepared, base, self._even, *wanted[key], known.get(key), self._states, self._setting.anew)
            for key in new
        )
        self._trials |= dict(zip(new, trials, strict=True))
        known.update({trial.law_key: trial.start for trial in trials if np.isfinite(trial.promise)})
        return [self._trials[key] for key in wanted]

    def fitted(self, trials: Sequence[Trial]) -> list[Model | None]:
        """Return a fitted model of each trial; None where the fit runs away."""
        prepared, floor = self._setting.prepared, self._setting.floor
        new = [trial for trial in trials if trial.law_key not in self._models]
        tried = self._setting.pool(
            delayed(_fit_trial)(prepared, self.base, self._weights, trial, floor) for trial in new
        )
        found = {
            trial.law_key: fitted.by_own_weights if fitted else None for trial, fitted in zip(new, tried, strict=True)
        }
        pairs = [(trial, fitted) for trial, fitted in zip(new, tried, strict=True) if fitted is not None]
        self._models |= found | self._elsewhere(pairs)
        return [self._models[trial.law_key] for trial in trials]

    def _elsewhere(self, tried: Sequence[tuple[Trial, _Fitted]]) -> dict[tuple[str, str, int], Model]:
        """Return models from other starts of laws that promise much and have ended where they cannot be meant.

        Not where another law leaves no more than noise, as a spring does of what passes for a play: there is nothing to
        find.
        """
        prepared, floor, pool = self._setting.prepared, self._setting.floor, self._setting.pool
        told = [fitted.by_own_weights for _, fitted in tried if meant(fitted.by_own_weights, prepared)]
        nothing = np.full(len(floor), np.inf)
        least = np.min([nothing, *(np.sqrt(np.mean(model.whole**2, axis=0)) for model in told)], axis=0)
        astray = [
            (trial, fitted)
            for trial, fitted in tried
            if trial.effect.nonlinear
            and trial.promise > MEANT * self.cost[trial.joint]
            and not meant(fitted.model, prepared)
            and least[trial.joint] > floor[trial.joint]
        ]
        wanted, weights = [(t.effect, t.joint) for t, _ in astray], [fitted.weights for _, fitted in astray]
        better = []
        for (trial, fitted), of in zip(astray, ends(prepared, self.base, weights, wanted, pool), strict=True):
            best = min((end for end in of if meant(end, prepared)), key=lambda end: end.fit.cost, default=fitted.model)
            if best.fit.cost < fitted.model.fit.cost:
                better.append((trial, best, fitted.weights))
        own = pool(delayed(_by_own_weights)(prepared, model, weights, floor) for _, model, weights in better)
        return {trial.law_key: model for (trial, *_), model in zip(better, own, strict=True)}

    def sought(self, joints: Collection[int]) -> list[Model]:
        """Return fitted models of the compliances that could be added at some joints, each from all of its starts.

        They are screened without their observer, where a link that swings freely in a wide play rings on: what they
        promise there, and from where, says little. Not those that were sought before, beside as much at that joint.
        """
        left = np.sqrt(np.mean(self.base.whole**2, axis=0))
        every = [(e, j) for e, j in self.possible if isinstance(e, TransmissionEffect) and j in joints]
        vain = [self._setting.vain.setdefault((e.name, e.law, j), []) for e, j in every]
        new = [
            not any(AS_MUCH < left[j] / rms < 1.0 / AS_MUCH for rms in before)
            for (_, j), before in zip(every, vain, strict=True)
        ]
        wanted = list(compress(every, new))
        if wanted:
            self._setting.progress(f"fitting {len(wanted)} compliances from every start")
        prepared, floor, pool = self._setting.prepared, self._setting.floor, self._setting.pool
        best = from_every_start(prepared, self.base, self._weights, wanted, pool)
        own = iter(pool(delayed(_by_own_weights)(prepared, model, self._weights, floor) for model in best if model))
        found = [next(own) if model else None for model in best]
        for (_, j), before, model in zip(wanted, compress(vain, new), found, strict=True):
            if model is None:
                before.append(float(left[j]))
        return [model for model in found if model is not None]


def _states(prepared: Prepared, base: Model) -> tuple[np.ndarray, ...] | None:
    """Return the states (N, nx) of a model along the fitted runs; None where it has none."""
    residual = Residual(SignalPath(prepared.arm, base.placed), prepared.fit, ())
    return tuple(residual.states(run, base.fit.p) for run in prepared.fit) if residual.path.x.numel() else None


class _Fitted(NamedTuple):
    """A model, the weights by which it was fitted, and the model once more by its own."""

    model: Model
    weights: Weights
    by_own_weights: Model


def _fit_trial(prepared: Prepared, base: Model, weights: Weights, trial: Trial, floor: np.ndarray) -> _Fitted | None:
    placed = (*base.placed, Placed(trial.effect, trial.joint))
    path = SignalPath(prepared.arm, placed)
    weights = Bristled(prepared, path, weights).at(start_values(path, base.fit, trial.start))
    far = trial.effect.rescales and bool(base.fit.at_limit)
    model = fit_model(prepared, placed, weights, base.fit, trial.start, evaluations=60 if far else 20)
    if not finite(model):
        return None
    short = base.fit.cost - model.fit.cost < SHORT * trial.promise
    if not model.fit.ok and (short or trial.effect.rescales):  # what that spares the prior is no part of the promise
        above = model.fit.cost > base.fit.cost
        known, start = (base.fit, trial.idle) if above else (model.fit, None)
        model = fit_model(prepared, placed, weights, known, start, evaluations=LONGER)
        if not finite(model):
            return None
    if isinstance(trial.effect, TransmissionEffect) and not trial.fitted:
        if trial.effect.damper:
            model = _with_less(trial.effect.damper, model, prepared, weights)
        left = np.sqrt(np.mean(model.fit.residual[:, trial.joint] ** 2))
        if trial.effect.room and left > MUCH * floor[trial.joint] and model.fit.cost < NEAR * base.fit.cost:
            model = _with_other(trial.effect.room, model, prepared, weights)
    return _Fitted(model, weights, _by_own_weights(prepared, model, weights, floor))


def _with_less(damper: str, model: Model, prepared: Prepared, weights: Weights) -> Model:
    """Return the better of a model and one that is fitted from it with the blows of its last effect all but undamped.

    Damped blows are smooth, and what screening finds without an observer is damped: no way leads from there to a play
    that knocks.
    """
    start = {**model.placed[-1].values, damper: LEAST_DAMPED * model.placed[-1].values[damper]}
    other = fit_model(prepared, model.placed, weights, model.fit, start, evaluations=20)
    return other if finite(other) and other.fit.cost < model.fit.cost else model


def _with_other(room: str, model: Model, prepared: Prepared, weights: Weights) -> Model:
    """Return the best of a model and those that are fitted from it with more and with less room for its last effect.

    When a link strikes depends on all strikes before: over the width of a play the cost has several valleys.
    """
    best = model
    for times in BETWEEN:
        start = {**model.placed[-1].values, room: times * model.placed[-1].values[room]}
        other = fit_model(prepared, model.placed, weights, model.fit, start, evaluations=20)
        if finite(other) and other.fit.cost < best.fit.cost:
            best = other
    return best


def _by_own_weights(prepared: Prepared, model: Model, weights: Weights, floor: np.ndarray) -> Model:
    """Return a model fitted once more by its own weights, in turn.

    A gap that is gone had made the whole joint count for little. One that is stopped on its way then goes on.
    """
    under_way = False
    for _ in range(AGAIN):
        own = weights_of(model, prepared, floor)
        as_before = np.all(np.mean(own.sd**2, axis=0) > RELIEVED**2 * np.mean(weights.sd**2, axis=0))
        if as_before and not under_way:
            break
        again = fit_model(prepared, model.placed, own, model.fit, evaluations=15)
        if not finite(again):
            break
        less = left_by(model.fit.residual, floor) - left_by(again.fit.residual, floor)
        under_way = not again.fit.ok and less > LEAST_GAIN
        model, weights = again, own
    return model
