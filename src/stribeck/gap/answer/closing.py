"""How much of the closable gap models close: the whole, and what one effect does of it, with intervals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from stribeck.gap.answer.noise import Heard
from stribeck.gap.fitted.model import Model
from stribeck.gap.fitted.noisy import put_back
from stribeck.gap.records.blocks import block_sums
from stribeck.gap.result import Estimate


@dataclass(frozen=True)
class Closing:
    """What models close on the held-out runs of what the re-tuned one leaves over the noise.

    Parameters
    ----------
    base : Model
        The re-tuned one.
    heard : Heard
        The noise, which nothing closes.
    block : array (M,) of int
        The block of each row of the held-out runs.
    draws : array (draws, blocks)
        Weights by which the blocks are drawn again, for intervals.
    """

    base: Model
    heard: Heard
    block: np.ndarray
    draws: np.ndarray

    def left(self, model: Model) -> np.ndarray:
        """Return a model's residual (M, n) on the held-out runs with all noise in it: less of it closes no gap."""
        told = self.heard
        return put_back(told.prepared, model.whole, model.noise, told.floor)[-len(model.held) :]

    def any_gap(self) -> bool:
        """Return whether re-tuning leaves more than noise: of less, nothing is to be closed."""
        return closable(self.left(self.base), self.heard.floor) > 0.0

    def by(self, model: Model) -> Estimate:
        """Return the part of the closable gap that a model closes, joints scaled by their floor."""
        value, *drawn = self._drawn(model)
        return with_interval(value, drawn)

    def by_effect(self, effect: str, chain: Sequence[Model]) -> Estimate:
        """Return the part of it that an effect's own steps close in a chain of models, of one effect more each."""
        closed = [np.zeros(1 + len(self.draws)), *(self._drawn(model) for model in chain[1:])]
        steps = zip(chain[1:], pairwise(closed), strict=True)
        own = [after - before for model, (before, after) in steps if model.placed[-1].effect.name == effect]
        value, *drawn = np.minimum(np.sum(own, axis=0), 1.0)  # nothing closes more than the whole
        return with_interval(value, drawn)

    def _drawn(self, model: Model) -> np.ndarray:
        """Return what a model closes for the rows as they are, and for each draw of their blocks: (1 + draws,).

        A draw with hardly a gap in it would tell any number: none counts below -1, as much again, unless the rows do.
        """
        left = self.left(self.base), self.left(model), self.heard.floor
        value, drawn = closure(*left), closed_again(*left, self.block, self.draws)
        return np.array([value, *np.maximum(drawn, min(value, -1.0))])


def closable(residual: np.ndarray, floor: np.ndarray) -> float:
    """Return what a residual (M, n) has over its floor (n,), in squared floors, summed over joints: a gap above 0.

    Not over those that leave nothing at all, held by brakes.
    """
    told = np.any(residual != 0.0, axis=0)
    return float(np.sum((np.mean(residual**2, axis=0) / floor**2 - 1.0)[told]))


def closure(before: np.ndarray, after: np.ndarray, floor: np.ndarray) -> float:
    """Return the part of the closable squared gap that is closed, 1 - (after^2 - floor^2) / (before^2 - floor^2).

    Of residuals (M, n), all joints scaled by their floor (n,); negative where it has grown.
    """
    return 1.0 - max(closable(after, floor), 0.0) / max(closable(before, floor), 1e-9)


def with_interval(value: float, drawn: np.ndarray | Sequence[float]) -> Estimate:
    """Return a value with the 95 % interval of what it is where the blocks are drawn again."""
    return Estimate(float(value), float(np.quantile(drawn, 0.025)), float(np.quantile(drawn, 0.975)))


def closed_again(
    before: np.ndarray, after: np.ndarray, floor: np.ndarray, block: np.ndarray, draws: np.ndarray
) -> np.ndarray:
    """Return the closed part for each of the weights (draws, blocks) by which the blocks are drawn again.

    Parameters
    ----------
    before, after : array (M, n)
        Residuals of two models, N m.
    floor : array (n,)
        Noise floor, N m rms.
    block : array (M,) of int
        The block of each row.
    draws : array (draws, blocks)
        Weights of the blocks, as of :func:`stribeck.gap.records.blocks.resampled`.
    """
    told = np.any(before != 0.0, axis=0)
    before, after, floor = before[:, told], after[:, told], floor[told]
    count = np.bincount(block).astype(float)
    first = draws @ block_sums(before**2, block) / (draws @ count)[:, None] / floor**2 - 1.0
    last = draws @ block_sums(after**2, block) / (draws @ count)[:, None] / floor**2 - 1.0
    return np.asarray(1.0 - np.maximum(last.sum(axis=1), 0.0) / np.maximum(first.sum(axis=1), 1e-9))
