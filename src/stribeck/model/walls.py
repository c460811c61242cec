"""Where a one-sided torque may begin: by what it would take of a residual."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stribeck.model.waves import Trace

SHARES = (0.1, 0.17, 0.25, 0.37, 0.5, 0.65, 0.75, 0.85, 0.92, 0.97)  # of the samples that lie before it
MOVING = 0.05  # of the rms speed
ROWS = 4000  # samples that are looked at, at most
WAYS = 24  # directions of a wall's normal
MOST = 3  # planes


def likeliest_walls(trace: Trace, exponent: float) -> list[tuple[float, float]]:
    """Return size and position (rad) of a torque size * max(side (q - position), 0) ** exponent for each side.

    The size has the sign of the side. The place is where it saves the most squares, of which a line and dry friction
    take none: both are re-tuned anyway. Rows at rest say nothing, for friction may be anything there.
    """
    moving = np.abs(trace.velocity) > MOVING * float(np.sqrt(np.mean(trace.velocity**2)))
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


def likeliest_planes(trace: Trace, exponent: float) -> list[tuple[float, float, float]]:
    """Return size, direction (rad) and distance (m) of walls that take most of all joints' residuals, best first.

    The force is size * max(n p - distance, 0) ** exponent along the normal n into the wall, at the tip p. A
    constant, dry friction and the joint's levers take none of the squares that it saves: weights and friction are
    re-tuned anyway.
    Empty where no wall pushes, or the trace tells of one joint alone.
    """
    if trace.reach is None:
        return []
    rows = slice(None, None, max(1, len(trace.time) // ROWS))
    levers, velocity, residual = (getattr(trace.reach, name)[rows] for name in ("levers", "velocity", "residual"))
    joints = [_Lever.of(levers[:, j], velocity[:, j], residual[:, j]) for j in range(residual.shape[1])]
    found = []
    for way in np.linspace(-np.pi, np.pi, WAYS, endpoint=False):
        normal = np.array([np.cos(way), np.sin(way)])
        along = levers[:, 0] @ normal
        places = np.quantile(along, SHARES)
        depth = np.maximum(along[:, None] - places, 0.0) ** exponent
        saved, size = np.sum([joint.against(normal, depth) for joint in joints], axis=0)
        size = np.maximum(saved, 0.0) / np.maximum(size, 1e-300)
        best = int(np.argmax(size * saved))
        found.append((size[best] * saved[best], float(size[best]), float(way), float(places[best])))
    worth = np.array([one[0] for one in found])
    peaks = np.flatnonzero((worth > 0.0) & (worth >= np.roll(worth, 1)) & (worth >= np.roll(worth, -1)))
    return [found[i][1:] for i in peaks[np.argsort(-worth[peaks])][:MOST]]


@dataclass(frozen=True)
class _Lever:
    """A joint's lever (M, 2) and residual (M,) while it moves, over its rms, and what re-tuning takes (M, 4)."""

    moving: np.ndarray
    lever: np.ndarray
    residual: np.ndarray
    others: np.ndarray

    @classmethod
    def of(cls, lever: np.ndarray, velocity: np.ndarray, residual: np.ndarray) -> _Lever:
        moving = np.abs(velocity) > MOVING * float(np.sqrt(np.mean(velocity**2)))
        given = np.column_stack([np.ones(len(lever)), np.sign(velocity), lever])[moving]
        others = np.linalg.qr(given)[0] if len(given) >= given.shape[1] else np.zeros_like(given)
        size = max(float(np.sqrt(np.mean(residual**2))), 1e-300)
        return cls(moving, lever / size, residual[moving] / size, others)

    def against(self, normal: np.ndarray, depth: np.ndarray) -> np.ndarray:
        """Return what walls of depths (M, D) share with the residual, and their own squares, (2, D)."""
        arm = self.lever[:, 0] * normal[1] - self.lever[:, 1] * normal[0]
        walls = (arm[:, None] * depth)[self.moving]
        walls = walls - self.others @ (self.others.T @ walls)
        return np.stack([self.residual @ walls, np.sum(walls**2, axis=0)])
