"""Where a one-sided torque may begin: by what it would take of a residual."""

from __future__ import annotations

import numpy as np

from stribeck.model.waves import Trace

SHARES = (0.03, 0.1, 0.17, 0.25, 0.37, 0.5, 0.65, 0.75, 0.85, 0.92, 0.97)  # of the samples that lie before it


def likeliest_wall(trace: Trace, exponent: float) -> tuple[float, float, float]:
    """Return size, side (1 or -1) and position (rad) of the torque size * max(side (q - position), 0) ** exponent.

    It is the one that saves the most squares, of which a line and dry friction take none: both are re-tuned anyway.
    """
    tried = []
    for side in (1.0, -1.0):
        places = [float(np.quantile(side * trace.position, share)) for share in SHARES]
        tried += [(*_size(side * trace.position - place, side, trace, exponent), side, place) for place in places]
    _, size, side, place = max(tried)
    return size, side, side * place


def _size(beyond: np.ndarray, side: float, trace: Trace, exponent: float) -> tuple[float, float]:
    """Return the squares that a wall saves, negative for one that pulls, and its size."""
    depth = np.maximum(beyond, 0.0) ** exponent
    others = np.stack([np.ones_like(depth), beyond, np.sign(trace.velocity)], axis=1)
    wall, left = (v - others @ np.linalg.lstsq(others, v, rcond=None)[0] for v in (depth, side * trace.residual))
    size = float(wall @ left) / max(float(wall @ wall), 1e-300)
    return float(wall @ left) * abs(size), size
