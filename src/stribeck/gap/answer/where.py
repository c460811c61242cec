"""Where the gap lies: the squared residual beyond noise by joint and region, with block-bootstrap intervals."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from stribeck.gap.records.blocks import block_sums, resampled
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.records.regions import region_masks
from stribeck.gap.result import Estimate, Region

DRAWS = 300


def regions(
    prepared: Prepared, before: np.ndarray, after: np.ndarray, noise: np.ndarray, seed: int
) -> tuple[Region, ...]:
    """Return each joint's residual region by region on the held-out runs.

    Parameters
    ----------
    prepared : Prepared
    before, after : array (M, n)
        Residual of the re-tuned and the corrected model, N m.
    noise : array (M, n)
        Noise floor, N m; its power is taken off before shares are formed, but for those of frequency bands.
    seed : int
    """
    block, draws = resampled(prepared.held, DRAWS, seed)
    out: list[Region] = []
    for j, joint in enumerate(prepared.arm.names):
        excess = before[:, j] ** 2 - noise[:, j] ** 2
        for family, masks in region_masks(prepared.held, j, prepared.arm.joints[j].kind).items():
            shares = _shares([np.where(mask, excess, 0.0) for mask in masks.values()], block, draws)
            for (region, mask), share in zip(masks.items(), shares, strict=True):
                out.append(
                    Region(
                        joint, family, region, share, float(mask.mean()), _rms(before[mask, j]), _rms(after[mask, j])
                    )
                )
        bands = _bands(prepared, before[:, j]), _bands(prepared, after[:, j])
        shares = _shares([rows**2 for rows in bands[0].values()], block, draws)
        for (band, rows), share in zip(bands[0].items(), shares, strict=True):
            out.append(Region(joint, "frequency", band, share, 1.0, _rms(rows), _rms(bands[1][band])))
    return tuple(out)


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2))) if len(values) else 0.0


def _shares(parts: Sequence[np.ndarray], block: np.ndarray, draws: np.ndarray) -> list[Estimate]:
    """Return what each part (M,) of a power has of all of them, with its interval."""
    value = _of_all(np.array([part.sum() for part in parts]))
    drawn = _of_all(np.array([draws @ block_sums(part, block) for part in parts]))
    low, high = np.quantile(drawn, (0.025, 0.975), axis=1)
    return [Estimate(float(v), float(a), float(b)) for v, a, b in zip(value, low, high, strict=True)]


def _of_all(parts: np.ndarray) -> np.ndarray:
    """Return the shares of parts (R, ...) in their sum, those that are less than their noise left out.

    There are none where all together are no more than their noise.
    """
    above = np.maximum(parts, 0.0)
    return np.asarray(above / np.where(parts.sum(axis=0) > 0.0, above.sum(axis=0), np.inf))


def _bands(prepared: Prepared, rows: np.ndarray) -> dict[str, np.ndarray]:
    """Return rows (M,) of the held-out runs split by frequency, run by run: each band's name and its part (M,)."""
    edges = (0.0, prepared.cutoff / 8, prepared.cutoff / 3, prepared.cutoff)
    spectra, start = [], 0
    for run in prepared.held:
        count = len(run.analysis_index)
        frequency = np.fft.rfftfreq(count, run.decimation * run.sample_time)
        spectra.append((count, frequency, np.fft.rfft(rows[start : start + count])))
        start += count
    bands = {}
    for i, (low, high) in enumerate(pairwise(edges)):
        top = np.inf if i == len(edges) - 2 else high
        parts = [np.fft.irfft(values * ((f >= low) & (f < top)), count) for count, f, values in spectra]
        bands[f"{low:.2g} to {high:.2g} Hz"] = np.concatenate(parts)
    return bands
