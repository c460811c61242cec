"""Where a one-sided torque begins, from a residual that holds one."""

import numpy as np
import pytest

from stribeck.model.walls import likeliest_wall
from stribeck.model.waves import Trace


@pytest.mark.parametrize("exponent", [1.0, 1.5])
@pytest.mark.parametrize(("side", "place"), [(1.0, 0.6), (-1.0, -0.3), (1.0, -0.4)])
def test_finds_the_wall(side: float, place: float, exponent: float) -> None:
    """Beside a line and dry friction, which re-tuning takes."""
    t = np.linspace(0.0, 20.0, 4000)
    position, velocity = np.sin(t), np.cos(t)
    wall = 30.0 * np.maximum(side * (position - place), 0.0) ** exponent
    residual = side * wall + 2.0 * np.sign(velocity) - 1.0 + 3.0 * position
    size, found, where = likeliest_wall(Trace(t, position, velocity, residual, residual), exponent)
    assert found == side
    assert where == pytest.approx(place, abs=0.25)
    assert 0.5 * 30.0 < size < 2.0 * 30.0
