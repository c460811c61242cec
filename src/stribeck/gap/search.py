"""Forward search: add the best effect while it earns its place on held-out data, then try to drop each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from joblib import Parallel, delayed

from stribeck.effects.registry import registry
from stribeck.gap.model import Model, fit_model, weights_of
from stribeck.gap.prepare import Prepared
from stribeck.gap.rank import Ranking, rank
from stribeck.gap.screen import Trial, candidates, screen
from stribeck.identify.map_fit import Weights
from stribeck.model.layout import Placed

LEAST_SURVIVORS = 3
MOST_SURVIVORS = 8
HOPEFUL = 0.3  # of the best promise: candidates with less are not fitted
MOST_EFFECTS = 3
LEAST_T = 2.8  # block-robust t value of the held-out gain
LEAST_GAIN = 0.06  # of the squared residual; held-out runs must show half of it
LEAST_FURTHER = 0.3  # the same for a further effect: less may be what the first one's law does not fit
SMALL_T, LARGE_GAIN = 2.0, 0.25  # a large gain may be less sure block by block, where few blocks excite it
ELUSIVE_T = 4.0  # for laws that also fit what filters do around rest
ABOVE = 0.7  # of the noise floor's power, which tends to be put too high: less is no gap
LEAST_POWER = 0.2  # of the noise floor's power, that an effect removes from a joint whose residual is above it
LEAST_PRIOR = 8.0  # cost that the prior must save for an effect that the residual alone does not show


@dataclass(frozen=True)
class Step:
    """One step of the search: the base, its rivals, how they rank, and whether the best was taken."""

    base: Model
    rivals: tuple[Model, ...]
    ranking: Ranking
    taken: bool
    screened_out: tuple[tuple[str, int], ...]

    @property
    def best(self) -> Model | None:
        """The best rival."""
        return self.rivals[self.ranking.best - 1] if self.rivals else None


Progress = Callable[[str], None]


def search(
    prepared: Prepared,
    base: Model,
    floor: np.ndarray,
    *,
    seed: int = 0,
    jobs: int = 2,
    leave_out: Sequence[str] = (),
    progress: Progress = lambda text: None,
) -> tuple[Step, ...]:
    """Return the steps of the forward search from the re-tuned model.

    Parameters
    ----------
    floor : array (n,)
        Noise floor on the held-out runs, N m rms.
    leave_out : sequence of str
        Effects that are no candidates.
    """
    steps: list[Step] = []
    known: dict[tuple[str, int], dict[str, float]] = {}
    with Parallel(n_jobs=jobs) as pool:
        while len(steps) < MOST_EFFECTS:
            step = _step(prepared, base, floor, seed, pool, leave_out, progress, known)
            steps.append(step)
            if not step.taken or step.best is None:
                break
            base = step.best
    return tuple(steps)


def _step(
    prepared: Prepared,
    base: Model,
    floor: np.ndarray,
    seed: int,
    pool: Parallel,
    leave_out: Sequence[str],
    progress: Progress,
    known: dict[tuple[str, int], dict[str, float]],
) -> Step:
    weights = weights_of(base.fit.residual, prepared, floor)
    base = fit_model(prepared, base.placed, weights, base.fit)
    known_before = bool(known)  # an earlier step has left its trials
    possible = candidates(prepared.arm, base.placed, leave_out)
    progress(f"screening {len(possible)} candidates")
    tried = pool(
        delayed(screen)(prepared, base, weights, effect, joint, known.get((effect.name, joint)))
        for effect, joint in possible
    )
    known.update({trial.key: trial.start for trial in tried})
    best_trials = _survivors(tried)
    progress(f"fitting {len({trial.key for trial in best_trials})} candidates")
    order = list(registry())
    best_trials = sorted(best_trials, key=lambda trial: (order.index(trial.effect.name), trial.joint))
    fitted = pool(delayed(_fit_trial)(prepared, base, weights, trial) for trial in best_trials)
    rivals = _best_of_each(fitted)
    ranking = rank(prepared, [base, *rivals], floor, seed)
    kept = {(model.placed[-1].effect.name, model.placed[-1].joint) for model in rivals}
    out = tuple((effect.name, joint) for effect, joint in possible if (effect.name, joint) not in kept)
    taken = bool(rivals) and _earns_its_place(ranking, rivals[ranking.best - 1], further=known_before)
    return Step(base, tuple(rivals), ranking, taken, out)


def _survivors(tried: Sequence[Trial]) -> list[Trial]:
    """Return the best trial of each candidate that is worth a full fit."""
    ordered = sorted(tried, key=lambda trial: -trial.promise)
    best = ordered[0].promise if ordered else 0.0
    return [
        trial
        for place, trial in enumerate(ordered)
        if np.isfinite(trial.promise) and (place < LEAST_SURVIVORS or trial.promise > HOPEFUL * best)
    ][:MOST_SURVIVORS]


def _fit_trial(prepared: Prepared, base: Model, weights: Weights, trial: Trial) -> Model | None:
    placed = (*base.placed, Placed(trial.effect, trial.joint))
    model = fit_model(prepared, placed, weights, base.fit, trial.start, evaluations=20)
    return model if np.all(np.isfinite(model.held)) else None


def _best_of_each(models: Sequence[Model | None]) -> list[Model]:
    """Return the cheapest model of each candidate, its placed effects carrying the fitted values."""
    best: dict[tuple[str, int], Model] = {}
    for model in models:
        if model is None:
            continue
        key = (model.placed[-1].effect.name, model.placed[-1].joint)
        if key not in best or model.fit.cost < best[key].fit.cost:
            best[key] = model
    return list(best.values())


def _earns_its_place(ranking: Ranking, best: Model, *, further: bool) -> bool:
    """Return whether the best rival is taken: it surely closes some of a gap above the floor; or the prior asks."""
    k = ranking.best
    gain, held, t = ranking.overall[k], ranking.gain[k, 0], ranking.t[k]
    before, after = ranking.power[0], ranking.power[k]
    above = bool(np.any((before > ABOVE) & (before - after > LEAST_POWER)))
    if best.placed[-1].effect.elusive:
        sure = t > ELUSIVE_T and gain > LARGE_GAIN
    else:
        sure = t > LEAST_T or (t > SMALL_T and gain > LARGE_GAIN and ranking.probability[0] < 0.01)
    least = LEAST_FURTHER if further else LEAST_GAIN
    agreed = held > 0.5 * least
    by_prior = ranking.prior_gain[k] > LEAST_PRIOR and gain > -LEAST_GAIN
    return bool((above and sure and gain > least and agreed) or by_prior)
