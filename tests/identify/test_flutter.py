"""Flutter is noise that the analysis does not see: never motion, however fast."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal
from scipy.interpolate import make_interp_spline

from stribeck.identify.conditioning import condition
from stribeck.identify.flutter import CALM, flutter
from stribeck.run import Run

from .conftest import pendulum

ANALYSIS, RATE, NOISY = 15.0, 1000.0, 1e-5  # Hz, Hz, rad


def conditioned(q: np.ndarray, noise: float) -> tuple[np.ndarray, np.ndarray]:
    """Return acceleration and flutter of a joint that was recorded at positions q (N,), away from the record's ends."""
    t = np.arange(len(q)) / RATE
    run = condition(pendulum(), Run("motion", t, q[:, None], np.zeros((len(q), 1))), ANALYSIS, np.array([noise]))
    inside = run.analysis_index
    inner = slice(inside[0], inside[-1])
    return run.acceleration[inner, 0], run.flutter[inner, 0]


def swing(frequency: float) -> np.ndarray:
    return 0.1 * np.sin(2 * np.pi * frequency * np.arange(8000) / RATE)


def noise(seed: int = 0) -> np.ndarray:
    return NOISY * np.random.default_rng(seed).standard_normal(8000)


@pytest.mark.parametrize("frequency", [0.5, 5.0, 45.0])
def test_motion_is_none(frequency: float) -> None:
    """Neither what the analysis sees nor three times its cutoff, as the motion's filter passes it."""
    acceleration, found = conditioned(swing(frequency), 1e-9)
    assert np.std(found) < 1e-5 * np.std(acceleration)


def test_noise_is_as_far_as_it_is_fast() -> None:
    """Next to none of it where the analysis looks, nearly all far above."""
    acceleration, found = conditioned(noise(), 10.0 * NOISY)
    frequency, whole = signal.welch(acceleration, RATE, nperseg=1000)
    gain = np.abs(signal.csd(acceleration, found, RATE, nperseg=1000)[1]) / whole
    assert gain[(frequency > 2.0) & (frequency < 0.5 * ANALYSIS)].max() < 0.05
    assert gain[(frequency > 4.0 * ANALYSIS) & (frequency < 6.0 * ANALYSIS)].min() > 0.9


@pytest.mark.parametrize(("said", "left_out"), [(1.0, 0.0027), (0.5, 0.134)])
def test_its_size_is_foreseen(said: float, left_out: float) -> None:
    """Three deviations are exceeded as often as in a normal distribution; more often if noise is said to be less."""
    cutoff, h = 90.0, 1.0 / RATE
    q = NOISY * np.random.default_rng(1).standard_normal(200_000)
    smooth = signal.sosfiltfilt(signal.butter(3, cutoff, fs=RATE, output="sos"), q)
    fast = make_interp_spline(h * np.arange(len(q)), smooth, k=5)(h * np.arange(len(q)), 2)
    found = flutter(fast[:, None], np.array([said * NOISY]), cutoff, ANALYSIS, h)
    assert np.mean(found == 0.0) == pytest.approx(left_out, rel=0.25)


def test_none_where_the_motion_is_smoother_than_the_analysis() -> None:
    assert not flutter(np.ones((50, 1)), np.ones(1), 2.0 * ANALYSIS, ANALYSIS, 1.0 / RATE).any()


LEAP = np.where(np.arange(4000) < 2000, -9.0, 0.0)[:, None]  # rad/s^2, as of a joint that comes to rest


def test_a_leap_is_motion() -> None:
    found = flutter(LEAP, np.array([1e-9]), 90.0, ANALYSIS, 1.0 / RATE)
    assert np.abs(found).max() < 1e-3


def test_beside_a_leap_it_does_not_ring_on() -> None:
    """Taken for noise as a whole, it is three thousandths of the leap a period of the filter away."""
    found = np.abs(flutter(LEAP, np.array([1.0]), 90.0, ANALYSIS, 1.0 / RATE)[:, 0])
    away = np.abs(np.arange(4000) - 1999.5) / RATE * CALM * ANALYSIS
    assert found.max() == pytest.approx(4.5, abs=0.5)
    assert found[away > 1.0].max() < 3e-3 * 9.0
