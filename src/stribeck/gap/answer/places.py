"""The short answer to where: joint, stage of the path and region, in shares of the whole gap."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from stribeck.arm import Arm
from stribeck.effects.registry import registry
from stribeck.gap.fitted.model import Model
from stribeck.gap.records.blocks import block_sums, resampled
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.records.regions import region_masks
from stribeck.gap.result import Estimate, Place
from stribeck.model.layout import Placed

DRAWS = 300
LEAST_SHARE = 0.02  # but for what an effect surely takes at a joint at which it is named
FAIR, MOST = 0.2, 0.6  # of a part of the gap, that a region of motion holds, and a place
FAR_MORE = 2.0  # times as dense as in any region of motion, the gap at a place that is told instead
UNNAMED = "unknown"


def places(
    prepared: Prepared,
    models: Sequence[Model],
    noise: np.ndarray,
    alike: Mapping[tuple[str, str], Sequence[str]],
    seed: int,
) -> tuple[Place, ...]:
    """Return the shares of the re-tuned model's gap, largest first.

    Each named effect takes the squared residual over the noise that its step removed, joint by joint, under its own
    stage of the path; what is left over the noise stays with ``unknown``. Joints count in units of their noise floor.

    Parameters
    ----------
    prepared : Prepared
    models : sequence of Model
        The re-tuned model and after it each model of the search that was taken.
    noise : array (M, n)
        Noise floor, N m.
    alike : mapping
        Named effect and joint -> effects that the data cannot tell from it there, whose stages of the path are
        possible as well.
    seed : int
        Of the bootstrap.
    """
    block, draws = resampled(prepared.held, DRAWS, seed)
    floor = np.mean(noise**2, axis=0)
    excess = [(model.held**2 - noise**2) / floor for model in models]
    left = [np.maximum(rows.sum(axis=0), 0.0) for rows in excess]
    drawn = [np.maximum(draws @ block_sums(rows, block), 0.0) for rows in excess]
    at = [*(model.placed[-1].joints(prepared.arm.n) for model in models[1:]), ()]
    channels = [*(_channels(model.placed[-1], prepared.arm, alike) for model in models[1:]), (UNNAMED,)]
    rows = [*(before - after for before, after in pairwise(excess)), excess[-1]]
    share, shares = _parts(left), _parts(drawn)
    out = []
    for k, possible in enumerate(channels):
        for j, joint in enumerate(prepared.arm.names):
            low, high = np.quantile(shares[k, :, j], (0.025, 0.975))
            if share[k, j] < LEAST_SHARE and not (j in at[k] and low > 0.0):
                continue
            estimate = Estimate(float(share[k, j]), float(low), float(high))
            out.append(Place(joint, possible[0], _region(prepared, j, rows[k][:, j]), estimate, possible))
    return tuple(sorted(out, key=lambda place: -place.share.value))


def _channels(place: Placed, arm: Arm, alike: Mapping[tuple[str, str], Sequence[str]]) -> tuple[str, ...]:
    """Return the stages of the path in which a placed effect may be, its own first."""
    others = (registry()[name].channel for name in alike.get((place.effect.name, arm.names[place.joint]), ()))
    return tuple(dict.fromkeys((place.effect.channel, *others)))


def _parts(left: Sequence[np.ndarray]) -> np.ndarray:
    """Return what each step takes of the gap, and what the last leaves, (K, ..., n), from what is ``left`` (..., n).

    A step that leaves a joint worse takes nothing there.
    """
    taken = np.maximum([*(before - after for before, after in pairwise(left)), left[-1]], 0.0)
    whole = np.sum(taken, axis=(0, -1))[..., None]
    return np.asarray(taken / np.where(whole > 0.0, whole, np.inf))


def _region(prepared: Prepared, joint: int, part: np.ndarray) -> str:
    """Return the region of motion in which a part of the gap is densest, among those that hold a fair share.

    Or the place that holds most of it, where that says far more: what one place has shows at some speeds as well.
    """
    masks = region_masks(prepared.held, joint, prepared.arm.joints[joint].kind)
    moving, at = (_densest(part, masks[family], least) for family, least in (("motion", FAIR), ("position", MOST)))
    name, density = max(moving, (at[0], at[1] / FAR_MORE), key=lambda found: found[1])
    return name if density > 0.0 else "all motion"


def _densest(part: np.ndarray, masks: Mapping[str, np.ndarray], least: float) -> tuple[str, float]:
    """Return the region in which a part is densest, of those that hold at least so much of it, and how dense."""
    sums = {name: float(part[mask].sum()) for name, mask in masks.items()}
    total = sum(max(value, 0.0) for value in sums.values()) or 1.0
    dense = {name: sums[name] / masks[name].sum() for name in sums if sums[name] > least * total}
    return max(dense.items(), key=lambda found: found[1], default=("", 0.0))
