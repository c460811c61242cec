"""Where a one-sided torque may begin: by what it would take of a residual."""

from __future__ import annotations

import numpy as np

from stribeck.model.waves import Trace

SHARES = (0.1, 0.17, 0.25, 0.37, 0.5, 0.65, 0.75, 0.85, 0.92, 0.97)  # of the samples that lie before it
MOVING = 0.05  # of the rms speed


def likeliest_walls(trace: Trace, exponent: float) -> list[tuple[float, float]]:
    """Return size and position (rad) of a torque size * max(side (q - position), 0) ** exponent for each side.

    The size has the sign of the side. The place is where it saves the most squares, of which a line and dry friction
    take none: both are re-tuned anyway. Rows at rest say nothing, for friction may be anything there; a joint that
    rests all along has no others, and its walls no size.
    """
    moving = np.abs(trace.velocity) >= MOVING * float(np.sqrt(np.mean(trace.velocity**2)))
    position, way, residual = trace.position[moving], np.sign(trace.velocity[moving]), trace.residual[moving]
    found = []
    for side in (1.0, -1.0):
        places = [float(np.quantile(side * position, share)) for share in SHARES]
        tried = [(*_size(side * position - place, way, side * residual, exponent), place) for place in places]
        _, size, place = max(tried)
        found.append((side * size, side * place))
    return found


def _size(beyond: np.ndarray, way: np.ndarray, residual: np.ndarray, exponent: float) -> tuple[float, float]:
    """Return the squares that a wall saves, negative for one that pulls, and its size."""
    depth = np.maximum(beyond, 0.0) ** exponent
    others = np.stack([np.ones_like(depth), beyond, way], axis=1)
    wall, left = (v - others @ np.linalg.lstsq(others, v, rcond=None)[0] for v in (depth, residual))
    size = float(wall @ left) / max(float(wall @ wall), 1e-300)
    return float(wall @ left) * abs(size), size
