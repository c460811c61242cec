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
            effect, scale = path.placed[entry.owner].effect, prepared.scales[entry.joint]
            parameter = next(p for p in effect.parameters if p.name == entry.name)
            null = scale.middle if parameter.place else parameter.null
            sizes = [abs(trial[entry.name] - null) for trial in effect.starts(scale) if np.isfinite(null)]
            usual = scale.travel if parameter.place else 1.0
            scales[entry.key] = max((size for size in sizes if size > 0.0), default=usual)
    return scales
