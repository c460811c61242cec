"""A signal that is moved in time, against the spline that it is read off."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from stribeck.effects.registry import effect_named
from stribeck.identify.conditioning import condition
from stribeck.identify.drives import Drives, _moved, delays_of
from stribeck.model.drive import DRIVE
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath

from .conftest import PENDULUM, pendulum, recorded

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


def test_what_a_late_record_is_unsure_of_moves_along_with_it() -> None:
    """Where a filter rings on beside a stop, its velocity says little: so it does at the time at which that was."""
    path = SignalPath(pendulum(), [Placed(effect_named("time_shift"), 0, {"time": 0.02})])
    run = condition(pendulum(), recorded(PENDULUM, rate=250.0, noise=1e-5), 20.0)
    rows = {name: DRIVE.index(name) for name in ("velocity", "velocity_sd")}
    plain, late = (
        Drives(path, [run]).along(run, delays) for delays in (np.zeros(1), delays_of(path, values_of(path.entries)))
    )
    assert np.ptp(plain[rows["velocity_sd"]]) > 0.0
    for name in rows:
        np.testing.assert_allclose(late[rows[name]][:-5], plain[rows[name]][5:], rtol=1e-6, atol=1e-9, err_msg=name)
