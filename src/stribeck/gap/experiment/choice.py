"""A programme of motions that may be recorded next, and what it promises beyond the recordings so far."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats

from stribeck.gap.experiment.changes import Change
from stribeck.gap.experiment.motions import Motion, Reach
from stribeck.gap.experiment.programme import Programme
from stribeck.gap.experiment.separation import AS_IT_IS, Prospect
from stribeck.gap.search.rank import ALIKE

TOLD_APART, WIDTH = 6.0, 3.0  # t value at which every other pair is told apart, and how fast that turns
LITTLE = 0.2  # probability below which two models are as good as not told apart


@dataclass(frozen=True)
class Options:
    """Motions that the arm's torque allows, with what they promise, within a ``reach``, ``wider`` than recorded.

    The ``change`` is made before.
    """

    motions: tuple[Motion, ...]
    prospects: tuple[Prospect, ...]
    reach: tuple[Reach, ...]
    wider: float
    change: Change = AS_IT_IS


@dataclass(frozen=True)
class SoFar:
    """What the recordings so far say: independent ``rows``, and by what square of a t value each model beats the base.

    ``gained`` is (K,).
    """

    rows: float
    gained: np.ndarray


@dataclass(frozen=True)
class Choice:
    """A programme of some of the ``options``, and what it promises beyond what is known ``so_far``."""

    programme: Programme
    prospect: Prospect
    options: Options
    so_far: SoFar

    @property
    def change(self) -> Change:
        """What is changed before."""
        return self.options.change

    @property
    def nearest(self) -> np.ndarray:
        """How far from each model (K,) the next one is, were it true."""
        pairs = self.prospect.pairs
        return np.asarray(np.min(np.where(np.eye(len(pairs), dtype=bool), np.inf, pairs), axis=1))

    @property
    def needed(self) -> np.ndarray:
        """How far from each model (K,) the next one must be for the search to tell them apart, were it true.

        A rival that gains all but as much, in logarithms, is the same story told by another formula
        (:meth:`stribeck.gap.search.rank.Ranking.twins`): the more an effect does, the more must lie between.
        """
        known = self.so_far if self.change is AS_IT_IS else SoFar(0.0, np.zeros_like(self.so_far.gained))
        rows = known.rows + self.prospect.rows
        gained = known.gained + self.prospect.apart[:, -1] ** 2
        return np.asarray(np.sqrt(rows * ((1.0 + gained / rows) ** (1.0 - ALIKE) - 1.0)))

    @property
    def chances(self) -> np.ndarray:
        """Probability (K, K) that the search tells two models apart, each as likely to be true; 0 for itself."""
        alone = stats.norm.cdf((self.prospect.pairs - np.maximum(self.needed, TOLD_APART)[:, None]) / WIDTH)
        return np.asarray(0.5 * (alone + alone.T) * (1.0 - np.eye(len(alone))))

    @property
    def apart(self) -> float:
        """How far apart the likeliest model and the one next to it are."""
        return float(self.nearest[0])

    @property
    def furthest(self) -> float:
        """How far apart the two models are that it sets apart most."""
        return float(np.max(self.prospect.pairs))


def resolved(nearest: np.ndarray, needed: np.ndarray | float = 0.0) -> float:
    """Return the probability that the search tells which of K models is true, each as likely.

    Parameters
    ----------
    nearest : array (K,)
        How far from each the next one is expected to be (t values).
    needed : array (K,)
        How far it must be at least.
    """
    return float(np.mean(stats.norm.cdf((nearest - np.maximum(needed, TOLD_APART)) / WIDTH)))
