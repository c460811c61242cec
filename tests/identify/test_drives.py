"""A signal that is moved in time, against the spline that it is read off."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from stribeck.identify.drives import _moved

STEP = 0.002


@pytest.mark.parametrize("later", [0.0, 0.0007, -0.0007, 0.002, -0.0061, 0.2, -0.31, 0.4, -0.4, 9.0, -9.0])
def test_moved(later: float) -> None:
    """Beyond its ends a signal stays as it is, and has no slope there."""
    time = 3.3 + STEP * np.arange(180)
    curve = CubicSpline(time, np.sin(7.0 * time) + 0.1 * time**2)
    asked = np.round((time + later) / STEP, 6) * STEP
    first, last = time[[0, -1]]
    outside = (asked < first - 1e-9) | (asked > last + 1e-9)
    value, slope = _moved(curve, later, STEP)
    np.testing.assert_allclose(value, curve(np.clip(asked, first, last)), atol=1e-11)
    np.testing.assert_allclose(slope, np.where(outside, 0.0, curve(np.clip(asked, first, last), 1)), atol=1e-8)
    assert np.ptp(slope) > 0.0 or abs(later) > 0.3
