"""From the steps of a search to a verdict, the causes and their probabilities."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stribeck.gap.blocks import block_sums
from stribeck.gap.model import Model
from stribeck.gap.result import Cause, Estimate
from stribeck.gap.search import Step

SILENT_TO = 1.6  # residual over noise floor up to which there is no gap: the floor is known to a factor of 1.5
AT_FLOOR = 1.4  # residual over noise floor up to which nothing is left to explain
HALFWAY, STEEPNESS = 0.77, 20.0  # explained part at which "unknown" is as likely as not, and how fast that turns
EACH_MORE = 0.05  # on the former for each further effect: several together fit much that they are not
PLAIN_T, PLAIN_CHANCE, PLAIN_GAIN = 5.0, 0.95, 0.1  # block-robust t, against its rivals, and sure held-out gain
PLAIN = 0.6  # presence of an effect that plain, however much others leave unexplained
CEILING = 0.92  # of any presence: of 145 surest names on sealed cases nine in ten were right
UNKNOWN_HELD = 0.65  # of the chance of "unknown": four of ten unexplained gaps were an effect of the library after all
MOST_SUSPECTS = 2
SURE_T, SURE_WIDTH = 2.0, 0.6  # block-robust t value that bears a name out to one half, and how fast that turns
NONE_HELD = 0.6  # of the chance of "none": every other sealed case without a visible gap hid an effect too weak to show
NAMED_OVER = 0.5  # probability of presence from which an effect is named


@dataclass(frozen=True)
class Closure:
    """Part of the closable squared gap that is closed: of all joints, and per joint (n,)."""

    total: float
    joints: np.ndarray


def closure(before: np.ndarray, after: np.ndarray, floor: np.ndarray) -> Closure:
    """Return 1 - (after^2 - floor^2) / (before^2 - floor^2) of residuals (M, n), joints scaled by their floor (n,)."""
    first, last = np.mean(before**2, axis=0) / floor**2, np.mean(after**2, axis=0) / floor**2
    part = 1.0 - np.maximum(last - 1.0, 0.0) / np.maximum(first - 1.0, 1e-9)
    per_joint = np.where(first > 1.0, part, 1.0)
    total = 1.0 - max(float(np.sum(last - 1.0)), 0.0) / max(float(np.sum(first - 1.0)), 1e-9)
    return Closure(total, per_joint)


def explained(left: np.ndarray, floor: np.ndarray, before: np.ndarray) -> np.ndarray:
    """Return how far each joint's gap is explained (n,), 0 to 1: by reaching the floor, or by what has gone."""
    ratio = np.sqrt(np.mean(left**2, axis=0)) / floor
    near = np.clip((2.0 * AT_FLOOR - ratio) / AT_FLOOR, 0.0, 1.0)
    gone = np.clip(closure(before, left, floor).joints, 0.0, 1.0)
    return np.asarray(np.maximum(near, gone))


def unknown_probability(part: float, effects: int = 1) -> float:
    """Return the probability that an effect outside the library is at work, from the part that others explain."""
    return float(1.0 / (1.0 + np.exp(STEEPNESS * (part - HALFWAY - EACH_MORE * (effects - 1)))))


def _plain(step: Step, chance: float) -> bool:
    """Return whether an effect shows so plainly that what else is unexplained speaks against it no more."""
    r = step.ranking
    turned_down = sum(r.probability[k] for k in range(1, len(r.probability)) if k not in {*step.passing, *r.twins()})
    clear = chance * (1.0 - turned_down) > PLAIN_CHANCE
    return bool(clear and r.t[r.best] > PLAIN_T and r.gain[r.best, 1] > PLAIN_GAIN)


def _surety(t: float) -> float:
    """Return how far the number and the agreement of the blocks bear a name out: few bear out little."""
    return float(1.0 / (1.0 + np.exp((SURE_T - t) / SURE_WIDTH)))


def _explained(base: Model, final: Model, floor: np.ndarray) -> np.ndarray:
    """Return the part explained (n,) on the held-out runs or on all, whichever is less."""
    whole = [np.concatenate([model.fit.residual, model.held]) for model in (final, base)]
    return np.asarray(np.minimum(explained(final.held, floor, base.held), explained(whole[0], floor, whole[1])))


def causes_of(steps: Sequence[Step], names: Sequence[str], floor: np.ndarray) -> tuple[list[Cause], float]:
    """Return the causes that the taken steps name, without parameters, and the probability of ``unknown``."""
    taken = [step for step in steps if step.taken]
    final = (taken[-1].best or steps[0].base) if taken else steps[0].base
    part = _explained(steps[0].base, final, floor)
    gathered: dict[str, list[tuple[int, float, float, tuple[str, ...]]]] = {}
    for step in taken:
        r, best = step.ranking, step.best
        assert best is not None
        place = best.placed[len(step.base.placed)]
        twins = [step.rivals[k - 1].placed[-1] for k in r.twins()]
        able = sum(r.probability[k] for k in {*step.passing, *r.twins()})
        chance = float(sum(r.probability[k] for k in r.twins()) / max(able, 1e-12))
        share = -float(np.log(max(1.0 - r.gain[r.best, 0], 1e-6)))
        presence = chance * (1.0 - unknown_probability(float(part[place.joint]), len(taken)))
        if step is taken[0] and _plain(step, chance):
            presence = max(presence, PLAIN * chance)
        presence *= CEILING * _surety(float(r.t[r.best]))
        gathered.setdefault(place.effect.name, []).append(
            (place.joint, presence, share, tuple(dict.fromkeys([place.effect.name, *[t.effect.name for t in twins]])))
        )
    whole = sum(share for rows in gathered.values() for _, _, share, _ in rows) or 1.0
    causes = []
    for effect, rows in gathered.items():
        presence = max(row[1] for row in rows)
        share = sum(row[2] for row in rows) / whole
        equivalent = tuple(dict.fromkeys(name for row in rows for name in row[3]))
        causes.append(
            Cause(effect, presence * share, tuple(names[row[0]] for row in rows), equivalent, presence=presence)
        )
    left_over = 1.0 - sum(cause.probability for cause in causes)
    return causes, max(left_over, 0.0)


def suspected(step: Step, causes: Sequence[Cause], unknown: float, names: Sequence[str]) -> list[Cause]:
    """Return the causes where no effect is named, ``unknown`` among them: what came nearest may be there all the same.

    Parameters
    ----------
    step : Step
        The last of the search.
    causes : sequence of Cause
        Effects that were taken, but do not explain enough to be named.
    unknown : float
        What they leave to ``unknown``, which keeps a part of it.
    names : sequence of str
        Of the joints.
    """
    near = list(causes)
    if not near:
        places = [step.rivals[k - 1].placed[-1] for k in step.ranking.order]
        first = {place.effect.name: place for place in reversed(places)}
        ordered = [place for place in places if first[place.effect.name] is place][:MOST_SUSPECTS]
        near = [Cause(p.effect.name, 0.0, (names[p.joint],), (p.effect.name,), presence=0.0) for p in ordered]
    if not near:
        return [Cause("unknown", unknown)]
    spare = (1.0 - UNKNOWN_HELD) * unknown / len(near)
    raised = [replace(c, probability=c.probability + spare, presence=(c.presence or 0.0) + spare) for c in near]
    return [*raised, Cause("unknown", UNKNOWN_HELD * unknown)]


def with_observed(
    verdict: str, causes: Sequence[Cause], seen: Sequence[Cause], in_torque: int
) -> tuple[str, list[Cause]]:
    """Return verdict and causes with those that the records show by themselves, which take their share.

    Parameters
    ----------
    causes : sequence of Cause
        From the torque, ``none`` and ``unknown`` included.
    seen : sequence of Cause
        From the records.
    in_torque : int
        Number of effects that the torque names.
    """
    if not seen:
        return verdict, list(causes)
    others = in_torque if verdict != "unexplained" else 1
    chance = sum(cause.presence or 0.0 for cause in seen) / len(seen)
    share = chance * len(seen) / (len(seen) + others)
    total = sum(cause.presence or 0.0 for cause in seen)
    own = [replace(cause, probability=share * (cause.presence or 0.0) / total) for cause in seen]
    rest = [replace(cause, probability=cause.probability * (1.0 - share)) for cause in causes]
    changed = {"no_gap": "explained", "unexplained": "partly_explained"}.get(verdict, verdict)
    return changed, [*own, *rest]


def no_gap_probability(step: Step, floor: np.ndarray) -> float:
    """Return the probability that nothing is there, where no effect was taken."""
    ratio = float(np.max(step.base.rms() / floor))
    # a rival that the search turned down says little against: it closes nothing above the floor
    chance = max(float(step.ranking.probability[0]), 0.5) ** 0.25
    return float(chance / (1.0 + np.exp(8.0 * (ratio - SILENT_TO))))


def closes_estimate(
    before: np.ndarray, after: np.ndarray, floor: np.ndarray, block: np.ndarray, draws: np.ndarray
) -> Estimate:
    """Return the closed part with its 95 % interval by Bayesian bootstrap over blocks."""
    count = np.bincount(block).astype(float)
    first = draws @ block_sums(before**2, block) / (draws @ count)[:, None] / floor**2 - 1.0
    last = draws @ block_sums(after**2, block) / (draws @ count)[:, None] / floor**2 - 1.0
    part = 1.0 - np.maximum(last.sum(axis=1), 0.0) / np.maximum(first.sum(axis=1), 1e-9)
    value = closure(before, after, floor).total
    return Estimate(value, float(np.quantile(part, 0.025)), float(np.quantile(part, 0.975)))
