"""Where a wall in the plane begins, from residuals that hold one."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.model.planes import likeliest_planes
from stribeck.model.waves import Reach, Trace


def chain(position: np.ndarray) -> np.ndarray:
    """Vectors (M, 2, 2) from the joints of links of 0.4 and 0.3 m to the tip."""
    first, second = position[:, 0], position.sum(axis=1)
    fore = 0.3 * np.stack([np.cos(second), np.sin(second)], axis=1)
    return np.stack([fore + 0.4 * np.stack([np.cos(first), np.sin(first)], axis=1), fore], axis=1)


@pytest.mark.parametrize("exponent", [1.0, 1.5])
@pytest.mark.parametrize(("way", "share"), [(0.9, 0.8), (-2.5, 0.9), (2.0, 0.6)])
def test_finds_the_wall_in_the_plane(way: float, share: float, exponent: float) -> None:
    """Beside wrong weights and dry friction at both joints."""
    t = np.linspace(0.0, 40.0, 6000)
    position, velocity = (np.stack(v, axis=1) for v in ((np.sin(t), np.cos(1.7 * t)), (np.cos(t), -np.sin(1.7 * t))))
    levers, normal = chain(position), np.array([np.cos(way), np.sin(way)])
    along = levers[:, 0] @ normal
    place = float(np.quantile(along, share))
    force = 200.0 * np.maximum(along - place, 0.0) ** exponent
    pushed = force[:, None] * (levers[:, :, 0] * normal[1] - levers[:, :, 1] * normal[0])
    residual = pushed + np.sign(velocity) + 2.0 * levers[:, :, 0]
    trace = Trace(t, *(v[:, 0] for v in (position, velocity, residual, residual)))
    assert likeliest_planes(trace, exponent) == []
    size, found, where = likeliest_planes(replace(trace, reach=Reach(levers, velocity, residual)), exponent)[0]
    assert abs(np.angle(np.exp(1j * (found - way)))) < 0.3
    assert where == pytest.approx(place, abs=0.2)  # of 1.4 m; a fit finds its way from there
    assert 0.4 * 200.0 < size < 2.5 * 200.0
    pulled = replace(trace, reach=Reach(levers, velocity, -pushed))
    assert all(size > 0.0 for size, _, _ in likeliest_planes(pulled, exponent))


def test_a_joint_that_is_held_does_not_speak() -> None:
    t = np.linspace(0.0, 40.0, 6000)
    held = np.full_like(t, 0.4)
    position, velocity = np.stack([np.sin(t), held], axis=1), np.stack([np.cos(t), 0.0 * held], axis=1)
    levers = chain(position)
    force = 200.0 * np.maximum(levers[:, 0, 1] - 0.45, 0.0)
    residual = force[:, None] * levers[:, :, 0]
    for noise in (0.0, 1e-12):
        quiet = residual * [1.0, 0.0] + noise * np.cos(50.0 * t)[:, None]
        shaken = velocity + 1e-6 * np.sin(70.0 * t)[:, None]
        trace = Trace(t, *(v[:, 0] for v in (position, velocity, quiet, quiet)), reach=Reach(levers, shaken, quiet))
        sizes = [size for size, _, _ in likeliest_planes(trace, 1.0)]
        assert 50.0 < sizes[0] < 800.0
        assert min(sizes) > 1.0
    silent = Trace(
        t, *(v[:, 0] for v in (position, velocity, residual, residual)), reach=Reach(levers, velocity, 0.0 * quiet)
    )
    assert likeliest_planes(silent, 1.0) == []
