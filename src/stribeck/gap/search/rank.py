"""Candidates judged side by side: held-out residuals, block by block, with the prior's say."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stribeck.gap.fitted.model import Model
from stribeck.gap.fitted.noisy import put_back
from stribeck.gap.records.blocks import (
    bayesian_bootstrap,
    block_of_rows,
    block_sums,
    correlation_rows,
    enough_blocks,
    t_value,
)
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.records.spread import levels, noise_power
from stribeck.identify.conditioning import Conditioned

DRAWS = 400
TIE = 1.0  # of log likelihood
SAME = 2.0  # block-robust t value below which two models are not told apart
SHARED = 0.75  # of the best model's gain (in logarithm): less is another story, not a twin
ALIKE_TIME = 0.25  # of a time, by which two may differ and still be one
ALIKE = 0.93  # of it: so close that a law's exact form, not the data, would decide


@dataclass(frozen=True)
class Ranking:
    """The base model and its rivals, one entry a model, the base first.

    Attributes
    ----------
    probability : array (K,)
        Of being the best, by Bayesian bootstrap over the blocks of all runs.
    loss : array (K, B, n)
        Squared residual per block of all runs and joint, in units of the best model's mean per block.
    gain : array (K, 3)
        Relative reduction of the held-out squared residual against the base, joints multiplied, with its 95 %
        interval.
    overall : array (K,)
        The same over all runs.
    t : array (K,)
        Block-robust t value of the gain over all runs.
    sure : array (K,)
        Probability, by the same bootstrap, that there is any gain over all runs.
    power : array (K, n)
        Mean square of the residual over all runs, in units of the noise floor's.
    lost : array (K,)
        What the held-out runs lose of squared residual, as a part of what the fitted ones gain; negative for a gain.
    prior_gain : array (K,)
        The prior's cost saved against the base.
    best : int
        The best rival's place; 0 where there is none.
    order : tuple of int
        The rivals by their score, best first.
    """

    probability: np.ndarray
    loss: np.ndarray
    gain: np.ndarray
    overall: np.ndarray
    t: np.ndarray
    sure: np.ndarray
    power: np.ndarray
    lost: np.ndarray
    prior_gain: np.ndarray
    best: int
    order: tuple[int, ...] = ()

    def twins(self) -> list[int]:
        """Return the rivals (not the base) that these data cannot tell from the best one, the best included."""
        return [k for k in range(1, len(self.loss)) if self._same(k)]

    def near(self) -> list[int]:
        """Return the rivals that gain all but as much as the best one, the best included, whatever else they ask for.

        By a large gap's own weights, constants that are re-tuned weigh more than what tells two models apart.
        """
        return [k for k in range(1, len(self.loss)) if self._keeps(k, ALIKE)]

    def without(self, k: int) -> Ranking:
        """Return the ranking without its k-th model, a rival that is not the best one."""
        rows = ("probability", "loss", "gain", "overall", "t", "sure", "power", "lost", "prior_gain")
        order = tuple(other - (other > k) for other in self.order if other != k)
        kept = {name: np.delete(getattr(self, name), k, axis=0) for name in rows}
        return replace(self, **kept, best=self.best - (self.best > k), order=order)

    def _same(self, k: int) -> bool:
        if k == self.best:
            return True
        apart = t_value(log_ratio(self.loss[k], self.loss[self.best]))
        by_data = self._keeps(k, SHARED if apart < SAME else ALIKE)
        by_prior = self.prior_gain[k] > self.prior_gain[self.best] - 2.0
        return bool(by_data and by_prior)

    def _keeps(self, k: int, part: float) -> bool:
        """Return whether a rival gains more than a part of what the best one gains, in logarithms."""
        return saved(self.overall[k]) > part * saved(self.overall[self.best])


def saved(gain: float) -> float:
    """Return a gain in logarithms: equal steps are equal factors of what is left."""
    return -float(np.log(max(1.0 - gain, 1e-12)))


def log_ratio(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return log(first / second) of block losses (B, n), summed over joints, (B,).

    Losses are in units of the best model's mean, and one tenth of that is added to both: a block in which nothing
    happens says nothing. Logarithms keep one violent block from deciding, as it would in a sum of squares.
    """
    return np.asarray(np.sum(np.log((first + 0.1) / (second + 0.1)), axis=1))


def rank(prepared: Prepared, models: Sequence[Model], floor: np.ndarray, seed: int) -> Ranking:
    """Rank models by their residuals on all runs, and measure their gains on the held-out ones.

    Parameters
    ----------
    prepared : Prepared
    models : sequence of Model
        The base first, then its rivals.
    floor : array (n,)
        Noise floor of the residual, N m rms.
    seed : int
        Of the bootstrap.

    Notes
    -----
    The likelihood is concentrated over each joint's own noise: n/2 log(sum of squares), counted in independent
    rows. An effect has few parameters against thousands of rows, so fitted runs may speak too; what they could be
    wrong about, the colour of the residual, the blocks account for. The held-out runs must agree (``gain``).
    Model weights by pseudo-BMA with the Bayesian bootstrap: Yao, Vehtari, Simpson & Gelman (2018).
    """
    runs = (*prepared.fit, *prepared.held)
    plain = [put_back(prepared, model.whole, model.noise, floor) for model in models]
    first = int(np.argmin([np.sum(np.log(np.mean(r**2, axis=0) + 0.5 * floor**2)) for r in plain]))
    rows = next((model.rows for model in (models[first], models[0]) if model.rows is not None), None)
    noise = noise_power(prepared.noise, floor, len(plain[first]), rows)
    level = levels(plain[first], noise, floor)
    whole = [residual * level for residual in plain]
    squares = _squares(whole, block_of_rows(runs), floor)
    total = squares.sum(axis=1)
    reference = int(np.argmin(np.sum(np.log(total), axis=1)))
    independent = _independent_rows(whole[reference], runs)
    prior = np.array([model.fit.prior for model in models])
    extra = np.array([0.5 * _own_parameters(model) * np.log(max(float(independent.mean()), 2.0)) for model in models])
    rng = np.random.default_rng(seed)
    weights = bayesian_bootstrap(squares.shape[1], DRAWS, rng)
    logs = np.log(np.einsum("db,kbj->dkj", weights, squares) + 1e-300)
    score = -0.5 * logs @ independent - prior - extra
    weight = np.exp(score - score.max(axis=1, keepdims=True))
    probability = (weight / weight.sum(axis=1, keepdims=True)).mean(axis=0)
    mean_score = -0.5 * np.log(total + 1e-300) @ independent - prior - extra
    order = _order(mean_score)
    if prepared.arm.n == 1:
        order = _late_command_first(models, order)
    best = order[0] if order else 0
    loss = squares / np.maximum(total[reference] / squares.shape[1], 1e-300)
    t = np.array([t_value(log_ratio(loss[0], row)) for row in loss])
    held = _squares([r[-len(models[0].held) :] for r in whole], enough_blocks(prepared.held), floor)
    draws = bayesian_bootstrap(held.shape[1], DRAWS, rng)
    held_logs = np.log(np.einsum("db,kbj->dkj", draws, held) + 1e-300)
    overall = 1.0 - np.exp(np.sum(np.log(total / total[0]), axis=1))
    sure = np.mean(np.sum(logs - logs[:, :1], axis=2) < 0.0, axis=0)
    power = np.array([np.mean(residual**2, axis=0) / floor**2 for residual in whole])
    gain = _gains(held_logs, held.sum(axis=1))
    less = np.sum((total[0] - total) / floor**2, axis=1)
    less_held = np.sum((held[0] - held).sum(axis=1) / floor**2, axis=1)
    lost = -less_held / np.maximum(less - less_held, 1e-9)
    return Ranking(probability, loss, gain, overall, t, sure, power, lost, prior[0] - prior, best, order)


def _order(score: np.ndarray) -> tuple[int, ...]:
    """Return the rivals, best first; of those that score the same, the one that the registry lists first."""
    left, order = list(range(1, len(score))), []
    while left:
        top = max(score[k] for k in left)
        order.append(next(k for k in left if score[k] > top - TIE))
        left.remove(order[-1])
    return tuple(order)


def _late_command_first(models: Sequence[Model], order: tuple[int, ...]) -> tuple[int, ...]:
    """Return the order with a late command before the record of the same joint that is late by as much.

    On one joint the two say the same, and where the samples happen to lie would decide. An early record stays, and one
    that is late at all joints.
    """
    times: dict[int, tuple[str, float]] = {}
    for k in order:
        place = models[k].placed[-1] if models[k].placed else None
        if place is not None and place.effect.delays and not place.effect.everywhere and "time" in place.values:
            times[k] = place.effect.delays, place.values["time"]
    record = next((k for k in order if k in times and times[k][0] == "position"), None)
    command = next((k for k in order if k in times and times[k][0] == "command"), None)
    if record is None or command is None or abs(times[command][1] - times[record][1]) > ALIKE_TIME * times[record][1]:
        return order
    rest = [k for k in order if k != command]
    first = min(order.index(command), rest.index(record))
    return (*rest[:first], command, *rest[first:])


def _squares(residuals: Sequence[np.ndarray], block: np.ndarray, floor: np.ndarray) -> np.ndarray:
    """Return squared residuals summed over blocks (K, B, n), with half the floor's power added.

    What a model changes below the noise is then no gap that it closes.
    """
    count = np.bincount(block).astype(float)
    return np.array([block_sums(residual**2, block) + 0.5 * np.outer(count, floor**2) for residual in residuals])


def _gains(logs: np.ndarray, total: np.ndarray) -> np.ndarray:
    """Return the relative reductions (K, 3) of the squared residual, value and 95 % interval."""
    drawn = 1.0 - np.exp(np.sum(logs - logs[:, :1], axis=2))
    low, high = np.quantile(drawn, [0.025, 0.975], axis=0)
    value = 1.0 - np.exp(np.sum(np.log((total + 1e-300) / (total[0] + 1e-300)), axis=1))
    return np.stack([value, low, high], axis=1)


def _independent_rows(residual: np.ndarray, runs: Sequence[Conditioned]) -> np.ndarray:
    """Return how many independent rows (n,) all runs amount to.

    The joint with the longest correlation counts for all: one whose residual is white noise would else outvote
    one with a gap.
    """
    return np.full(residual.shape[1], len(residual) / float(np.max(correlation_rows(residual, runs))))


def _own_parameters(model: Model) -> int:
    return model.absorbed + sum(isinstance(entry.owner, int) for entry in model.fit.entries)
