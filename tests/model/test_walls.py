"""Where a one-sided torque begins, from a residual that holds one."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.model.walls import likeliest_planes, likeliest_walls
from stribeck.model.waves import Reach, Trace


@pytest.mark.parametrize("exponent", [1.0, 1.5])
@pytest.mark.parametrize(("side", "place"), [(1.0, 0.6), (-1.0, -0.3), (1.0, -0.4)])
def test_finds_the_wall(side: float, place: float, exponent: float) -> None:
    """Beside a line and dry friction, which re-tuning takes."""
    t = np.linspace(0.0, 20.0, 4000)
    position, velocity = np.sin(t), np.cos(t)
    wall = 30.0 * np.maximum(side * (position - place), 0.0) ** exponent
    residual = side * wall + 2.0 * np.sign(velocity) - 1.0 + 3.0 * position
    found = likeliest_walls(Trace(t, position, velocity, residual, residual), exponent)
    size, where = found[0] if side > 0.0 else found[1]
    assert where == pytest.approx(place, abs=0.25)
    assert 0.5 * 30.0 < side * size < 2.0 * 30.0


def test_what_rests_at_an_end_of_the_travel_is_no_wall() -> None:
    """A tenth of the rows rest at one end, where friction holds what it likes; the wall is at the other."""
    t = np.linspace(0.0, 20.0, 4000)
    resting = t > 18.0
    position = np.where(resting, -1.0, np.sin(t))
    velocity = np.where(resting, 0.0, np.cos(t))
    residual = 3.0 * np.maximum(position - 0.6, 0.0) + np.where(resting, 2.0, 0.0)
    (size, where), _ = likeliest_walls(Trace(t, position, velocity, residual, residual), 1.0)
    assert where == pytest.approx(0.6, abs=0.15)
    assert 2.0 < size < 5.0


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
