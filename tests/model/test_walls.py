"""Where a one-sided torque begins, from a residual that holds one."""

import numpy as np
import pytest

from stribeck.model.walls import likeliest_walls
from stribeck.model.waves import Trace


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


@pytest.mark.parametrize("place", [0.0, 0.7])
def test_a_joint_that_rests_all_along_has_no_wall(place: float) -> None:
    """As one does that reads the same number in all runs: its velocity is 0 to the last digit."""
    still, residual = np.zeros(400), np.random.default_rng(0).standard_normal(400)
    found = likeliest_walls(Trace(still, still + place, still, residual, residual), 1.5)
    assert [size for size, _ in found] == pytest.approx([0.0, 0.0])
    assert [where for _, where in found] == pytest.approx([place, place])
