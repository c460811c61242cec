"""Where the gap lies: the squared residual by joint and region of the motion, with block-bootstrap intervals."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from stribeck.gap.blocks import bayesian_bootstrap, block_of_rows, block_sums
from stribeck.gap.prepare import Prepared
from stribeck.gap.result import Estimate, Region
from stribeck.identify.conditioning import Conditioned

DRAWS = 300
NEAR_REVERSAL = 0.08  # s
POSITION_BINS = 6


def analysis_signals(runs: Sequence[Conditioned]) -> dict[str, np.ndarray]:
    """Return position, velocity, acceleration and command (M, n) at the analysis samples, and time in run (M,)."""
    out = {
        name: np.concatenate([getattr(run, name)[run.analysis_index] for run in runs])
        for name in ("position", "velocity", "acceleration", "stuck")
    }
    out["command"] = np.concatenate([run.filtered(run.command) for run in runs])
    out["time"] = np.concatenate([run.time[run.analysis_index] - run.time[0] for run in runs])
    out["share"] = np.concatenate([np.linspace(0.0, 1.0, len(run.analysis_index)) for run in runs])
    return out


def region_masks(runs: Sequence[Conditioned], joint: int) -> dict[str, dict[str, np.ndarray]]:
    """Return family -> region -> mask (M,) over the analysis samples; the regions of a family partition them."""
    s = analysis_signals(runs)
    velocity, position = s["velocity"][:, joint], s["position"][:, joint]
    near = np.concatenate([_near_reversal(run, joint) for run in runs])
    stuck = (s["stuck"][:, joint] > 0.5) & ~near
    moving = ~near & ~stuck
    speed = np.abs(velocity)
    low, high = np.quantile(speed[moving], [1 / 3, 2 / 3]) if moving.any() else (0.0, 0.0)
    families = {
        "motion": {
            "velocity reversal": near,
            "stuck": stuck,
            "low velocity": moving & (speed <= low),
            "medium velocity": moving & (speed > low) & (speed <= high),
            "high velocity": moving & (speed > high),
        },
        "direction": {"forward": (velocity > 0) & ~stuck, "backward": (velocity <= 0) & ~stuck, "at rest": stuck},
        "position": _bins(position),
        "load": _thirds(np.abs(s["command"][:, joint]), "load"),
        "acceleration": _thirds(np.abs(s["acceleration"][:, joint]), "acceleration"),
        "time": {
            "first third of a run": s["share"] < 1 / 3,
            "middle third of a run": (s["share"] >= 1 / 3) & (s["share"] < 2 / 3),
            "last third of a run": s["share"] >= 2 / 3,
        },
    }
    return {family: {k: m for k, m in masks.items() if m.any()} for family, masks in families.items()}


def _bins(position: np.ndarray) -> dict[str, np.ndarray]:
    """Return equal bins of the travel, named with as many digits as tell them apart."""
    low, high = float(position.min()), float(position.max())
    step = (high - low) / POSITION_BINS
    if step <= 1e-12 * (1.0 + abs(low)):
        return {f"{low:.2f} rad": np.ones(len(position), dtype=bool)}
    digits = max(2, 1 - int(np.floor(np.log10(step))))
    edges = np.linspace(low, high, POSITION_BINS + 1)
    place = np.searchsorted(edges[1:-1], position, side="right")
    return {f"{a:.{digits}f} to {b:.{digits}f} rad": place == i for i, (a, b) in enumerate(pairwise(edges))}


def _thirds(size: np.ndarray, name: str) -> dict[str, np.ndarray]:
    low, high = np.quantile(size, [1 / 3, 2 / 3])
    return {
        f"low {name}": size <= low,
        f"medium {name}": (size > low) & (size <= high),
        f"high {name}": size > high,
    }


def _near_reversal(run: Conditioned, joint: int) -> np.ndarray:
    velocity, stuck = run.velocity[:, joint], run.stuck[:, joint] > 0.5
    sign = np.sign(np.where(stuck, 0.0, velocity))
    last = np.zeros_like(sign)
    seen = np.flatnonzero(sign != 0)
    if len(seen) == 0:
        return np.zeros(len(run.analysis_index), dtype=bool)
    last[seen] = sign[seen]
    turns = seen[1:][np.diff(sign[seen]) != 0]
    width = max(1, round(NEAR_REVERSAL / run.sample_time))
    near = np.zeros(len(velocity), dtype=bool)
    for i in turns:
        near[max(0, i - width) : i + width] = True
    return np.asarray(near[run.analysis_index])


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
        families = dict(region_masks(prepared.held, j))
        for family, masks in families.items():
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
