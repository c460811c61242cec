"""The short answer to where: joint, stage of the path and region, in shares of the whole gap."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stribeck.gap.fitted.model import Model
from stribeck.gap.records.blocks import block_sums, resampled
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.records.regions import motion_masks
from stribeck.gap.result import Estimate, Place, Region

DRAWS = 300
LEAST_SHARE = 0.02
UNNAMED = "unknown"


def places(
    prepared: Prepared, models: Sequence[Model], noise: np.ndarray, regions: Sequence[Region], seed: int
) -> tuple[Place, ...]:
    """Return the shares of the re-tuned model's gap, largest first.

    Each named effect takes the squared residual that its step removed, joint by joint, under its own stage of the
    path; what is left over the noise stays with ``unknown``. Joints count in units of their noise floor.

    Parameters
    ----------
    models : sequence of Model
        The re-tuned model and after it each model of the search that was taken.
    noise : array (M, n)
        Noise floor, N m.
    """
    block, draws = resampled(prepared.held, DRAWS, seed)
    floor = np.mean(noise**2, axis=0)
    squares = [model.held**2 / floor for model in models]
    removed = [
        (after.placed[-1].effect.channel, before - left)
        for before, left, after in zip(squares[:-1], squares[1:], models[1:], strict=True)
    ]
    removed.append((UNNAMED, squares[-1] - noise**2 / floor))
    whole = draws @ block_sums((squares[0] - noise**2 / floor).sum(axis=1), block)
    total = float((squares[0] - noise**2 / floor).sum())
    if total <= 0.0:
        return ()
    out = []
    for channel, part in removed:
        for j, joint in enumerate(prepared.arm.names):
            share = float(part[:, j].sum()) / total
            if share < LEAST_SHARE:
                continue
            drawn = np.clip(draws @ block_sums(part[:, j], block) / np.where(whole > 0, whole, np.inf), 0.0, 1.0)
            estimate = Estimate(min(share, 1.0), float(np.quantile(drawn, 0.025)), float(np.quantile(drawn, 0.975)))
            out.append(Place(joint, channel, _region(prepared, j, part[:, j]), estimate))
    return tuple(sorted(out, key=lambda place: -place.share.value))


def _region(prepared: Prepared, joint: int, part: np.ndarray) -> str:
    """Return the region of motion in which a part of the gap is densest, among those that hold a fair share."""
    masks = motion_masks(prepared.held, joint)
    sums = {name: float(part[mask].sum()) for name, mask in masks.items()}
    total = sum(max(value, 0.0) for value in sums.values()) or 1.0
    fair = {name: sums[name] / masks[name].sum() for name in sums if sums[name] > 0.2 * total}
    return max(fair, key=lambda name: fair[name]) if fair else "all motion"
