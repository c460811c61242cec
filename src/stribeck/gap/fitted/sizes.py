"""How large effects' parameters typically are."""

from __future__ import annotations

import numpy as np

from stribeck.gap.records.prepare import Prepared
from stribeck.model.path import SignalPath


def effect_scales(path: SignalPath, prepared: Prepared) -> dict[str, float]:
    """Return a typical size of every effect parameter, by key, from the effects' own trial values."""
    scales: dict[str, float] = {}
    for entry in path.entries:
        if isinstance(entry.owner, int):
            trials = path.placed[entry.owner].effect.starts(prepared.scales[entry.joint])
            null = next(p.null for p in path.placed[entry.owner].effect.parameters if p.name == entry.name)
            sizes = [abs(trial[entry.name] - null) for trial in trials if np.isfinite(null)]
            sizes = [size for size in sizes if size > 0.0]
            scales[entry.key] = max(sizes) if sizes else 1.0
    return scales
