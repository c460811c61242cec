"""Where the gap lies: the squared residual by joint and region of the motion, with block-bootstrap intervals."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from stribeck.gap.records.blocks import bayesian_bootstrap, block_of_rows, block_sums
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.records.regions import region_masks
from stribeck.gap.result import Estimate, Region
from stribeck.identify.conditioning import Conditioned

DRAWS = 300


def regions(
    prepared: Prepared, before: np.ndarray, after: np.ndarray, noise: np.ndarray, seed: int
) -> tuple[Region, ...]:
    """Return each joint's residual region by region on the held-out runs.

    Parameters
    ----------
    before, after : array (M, n)
        Residual of the re-tuned and the corrected model, N m.
    noise : array (M, n)
        Noise floor, N m; its power is taken off before shares are formed.
    seed : int
    """
    block = block_of_rows(prepared.held)
    draws = bayesian_bootstrap(int(block.max()) + 1, DRAWS, np.random.default_rng(seed))
    out: list[Region] = []
    for j, joint in enumerate(prepared.arm.names):
        excess = before[:, j] ** 2 - noise[:, j] ** 2
        for family, masks in region_masks(prepared.held, j, prepared.arm.joints[j].kind).items():
            for region, mask in masks.items():
                share = _share(excess, mask, block, draws)
                out.append(
                    Region(
                        joint, family, region, share, float(mask.mean()), _rms(before[mask, j]), _rms(after[mask, j])
                    )
                )
        out += _bands(prepared, joint, before[:, j], after[:, j])
    return tuple(out)


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2))) if len(values) else 0.0


def _share(excess: np.ndarray, mask: np.ndarray, block: np.ndarray, draws: np.ndarray) -> Estimate:
    inside = draws @ block_sums(np.where(mask, excess, 0.0), block)
    whole = draws @ block_sums(excess, block)
    share = np.clip(inside / np.where(np.abs(whole) > 1e-300, whole, 1.0), 0.0, 1.0)
    total = float(excess.sum())
    value = float(np.clip(excess[mask].sum() / total, 0.0, 1.0)) if total > 0.0 else 0.0
    return Estimate(value, float(np.quantile(share, 0.025)), float(np.quantile(share, 0.975)))


def _bands(prepared: Prepared, joint: str, before: np.ndarray, after: np.ndarray) -> list[Region]:
    """Return the residual by frequency band, from each run's periodogram."""
    edges = (0.0, prepared.cutoff / 8, prepared.cutoff / 3, prepared.cutoff)
    names = [f"{a:.2g} to {b:.2g} Hz" for a, b in pairwise(edges)]
    power = [_band_power(prepared.held, values, edges) for values in (before, after)]
    shares = power[0] / np.maximum(power[0].sum(axis=1, keepdims=True), 1e-300)
    mean = power[0].sum(axis=0) / max(float(power[0].sum()), 1e-300)
    rows = sum(len(run.analysis_index) for run in prepared.held)
    out = []
    for i, name in enumerate(names):
        estimate = Estimate(float(mean[i]), float(shares[:, i].min()), float(shares[:, i].max()))
        rms = [float(np.sqrt(p[:, i].sum() / rows)) for p in power]
        out.append(Region(joint, "frequency", name, estimate, 1.0, rms[0], rms[1]))
    return out


def _band_power(runs: Sequence[Conditioned], values: np.ndarray, edges: Sequence[float]) -> np.ndarray:
    """Return the summed squares (runs, bands) of row values split by frequency."""
    out = []
    start = 0
    for run in runs:
        rows = len(run.analysis_index)
        spectrum = np.abs(np.fft.rfft(values[start : start + rows])) ** 2
        spectrum[1:] *= 2.0
        frequency = np.fft.rfftfreq(rows, run.decimation * run.sample_time)
        start += rows
        last = len(edges) - 2
        bands = [(frequency >= a) & ((frequency < b) | (i == last)) for i, (a, b) in enumerate(pairwise(edges))]
        out.append([float(spectrum[band].sum()) / max(rows, 1) for band in bands])
    return np.array(out)
