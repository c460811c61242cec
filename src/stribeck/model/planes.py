"""A straight wall in the plane that an arm's tip runs into: its force, and where it may begin."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from stribeck.model.scale import Scale
from stribeck.model.values import Expression, Parameters, Tip
from stribeck.model.walls import MOVING, SHARES
from stribeck.model.waves import Trace

ROWS = 4000  # samples that are looked at, at most
WAYS = 24  # directions of a wall's normal
MOST = 3  # planes
HELD, QUIET = 0.1, 1e-3  # of the fastest joint's speed and the largest residual, below which a joint counts as that
DAMPING = 0.2  # s/m, with which a fit starts
CORNERS = (0.8, 2.4, -2.4, -0.8)  # rad


def plane_force(tip: Tip, p: Parameters, exponent: float) -> tuple[Expression, Expression]:
    """Return the force (x, y), N, that presses a tip into a wall: k d^e (1 + c d') after Hunt & Crossley (1975).

    ``stiffness``, ``direction`` of the normal into it, ``distance`` along that, and ``damping``; it does not pull.
    """
    cos, sin = ca.cos(p["direction"]), ca.sin(p["direction"])
    depth = ca.fmax(tip.x * cos + tip.y * sin - p["distance"], 0.0)
    force = p["stiffness"] * depth**exponent * ca.fmax(1.0 + p["damping"] * (tip.dx * cos + tip.dy * sin), 0.0)
    return force * cos, force * sin


def plane_starts(scale: Scale, exponent: float) -> tuple[dict[str, float], ...]:
    """Return values of walls about an arm, by the length of its first link."""
    reach = scale.length or 1.0
    size = scale.torque / reach / (0.1 * reach) ** exponent
    return tuple({"stiffness": size, "direction": way, "distance": 0.9 * reach, "damping": DAMPING} for way in CORNERS)


def planes_from(scale: Scale, trace: Trace, exponent: float) -> tuple[dict[str, float], ...]:
    """Return values of the likeliest walls, or of some where none is likely."""
    found = tuple(
        {"stiffness": size, "direction": way, "distance": place, "damping": DAMPING}
        for size, way, place in likeliest_planes(trace, exponent)
    )
    return found or plane_starts(scale, exponent)


def likeliest_planes(trace: Trace, exponent: float) -> list[tuple[float, float, float]]:
    """Return size, direction (rad) and distance (m) of walls that take most of all joints' residuals, best first.

    The force is size * max(n p - distance, 0) ** exponent along the normal n into the wall, at the tip p. A
    constant, dry friction and the joint's levers take none of the squares that it saves: weights and friction are
    re-tuned anyway. Empty where no wall pushes, or the trace tells of one joint alone.
    """
    if trace.reach is None:
        return []
    rows = slice(None, None, max(1, len(trace.time) // ROWS))
    levers, velocity, residual = (getattr(trace.reach, name)[rows] for name in ("levers", "velocity", "residual"))
    speed, size = (np.sqrt(np.mean(values**2, axis=0)) for values in (velocity, residual))
    if not size.any():
        return []
    # a joint that is held says nothing, whatever noise its record has
    slow, size = MOVING * np.maximum(speed, HELD * speed.max()), np.maximum(size, QUIET * size.max())
    joints = [
        _Lever.of(levers[:, j], velocity[:, j], residual[:, j], slow[j], size[j]) for j in range(residual.shape[1])
    ]
    found = []
    for way in np.linspace(-np.pi, np.pi, WAYS, endpoint=False):
        normal = np.array([np.cos(way), np.sin(way)])
        along = levers[:, 0] @ normal
        places = np.quantile(along, SHARES)
        depth = np.maximum(along[:, None] - places, 0.0) ** exponent
        saved, square = np.sum([joint.against(normal, depth) for joint in joints], axis=0)
        size = np.maximum(saved, 0.0) / np.maximum(square, 1e-12 * len(depth))
        best = int(np.argmax(size * saved))
        found.append((size[best] * saved[best], float(size[best]), float(way), float(places[best])))
    worth = np.array([one[0] for one in found])
    peaks = np.flatnonzero((worth > 0.0) & (worth >= np.roll(worth, 1)) & (worth >= np.roll(worth, -1)))
    return [found[i][1:] for i in peaks[np.argsort(-worth[peaks])][:MOST]]


@dataclass(frozen=True)
class _Lever:
    """A joint's lever (M, 2) and residual (M,) while it moves, over a scale, and what re-tuning takes (M, 4)."""

    moving: np.ndarray
    lever: np.ndarray
    residual: np.ndarray
    others: np.ndarray

    @classmethod
    def of(cls, lever: np.ndarray, velocity: np.ndarray, residual: np.ndarray, slow: float, size: float) -> _Lever:
        """Take a joint that moves where it is faster than ``slow``, and weigh it by its ``size``."""
        moving = np.abs(velocity) > slow
        given = np.column_stack([np.ones(len(lever)), np.sign(velocity), lever])[moving]
        others = np.linalg.qr(given)[0] if len(given) >= given.shape[1] else np.zeros_like(given)
        return cls(moving, lever / size, residual[moving] / size, others)

    def against(self, normal: np.ndarray, depth: np.ndarray) -> np.ndarray:
        """Return what walls of depths (M, D) share with the residual, and their own squares, (2, D)."""
        arm = self.lever[:, 0] * normal[1] - self.lever[:, 1] * normal[0]
        walls = (arm[:, None] * depth)[self.moving]
        walls = walls - self.others @ (self.others.T @ walls)
        return np.stack([self.residual @ walls, np.sum(walls**2, axis=0)])
