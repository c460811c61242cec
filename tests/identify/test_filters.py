"""The analysis filter, several samples at a time, against one after the other."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal

from stribeck.identify.filters import decimated, low_pass


@given(st.integers(0, 400), st.integers(1, 40), st.integers(1, 12), st.integers(1, 5))
def test_decimated(samples: int, half: int, every: int, rows: int) -> None:
    taps = signal.firwin(2 * half + 1, 0.2)
    values = np.random.default_rng(samples).normal(size=(rows, samples))
    count = max(0, -(-(samples - 2 * half) // every))
    slow = [np.convolve(row, taps, "valid")[::every] if count else np.empty(0) for row in values]
    found = decimated(values, taps, every)
    assert found.shape == (rows, count)
    np.testing.assert_allclose(found, np.reshape(slow, found.shape), rtol=0.0, atol=1e-13)


@pytest.mark.parametrize("every", [1, 3, 7])
def test_of_a_steady_signal_nothing_is_lost(every: int) -> None:
    found = decimated(np.full((2, 500), 3.0), low_pass(20.0, 0.002), every)
    np.testing.assert_allclose(found, 3.0, rtol=1e-12)


@pytest.mark.parametrize("wrong", [np.inf, -np.inf, np.nan, 1e308])
def test_what_has_run_away_is_seen_and_not_warned_of(wrong: float) -> None:
    values = np.ones((2, 500))
    values[1, 200:210] = wrong
    found = decimated(values, 3.0 * low_pass(20.0, 0.002), 3)
    np.testing.assert_allclose(found[0], 3.0)
    assert not np.all(np.abs(found[1]) < 1e150)


@pytest.mark.parametrize(("cutoff", "corner"), [(10.0, 3.5), (10.0, 7.0), (30.0, 10.5), (40.0, 28.0)])
@pytest.mark.parametrize("rate", [400.0, 1000.0])
def test_a_roll_off_leaves_noise_that_rises_with_the_square_even(cutoff: float, corner: float, rate: float) -> None:
    flat, rolled = low_pass(cutoff, 1.0 / rate), low_pass(cutoff, 1.0 / rate, corner)
    assert len(rolled) == len(flat)
    assert rolled == pytest.approx(rolled[::-1], abs=1e-12)
    assert np.sum(rolled) == pytest.approx(1.0)
    frequency = np.linspace(0.0, 0.75 * cutoff, 50)
    passed = [np.abs(signal.freqz(taps, worN=frequency, fs=rate)[1]) for taps in (flat, rolled)]
    assert passed[1] / passed[0] == pytest.approx(1.0 / np.sqrt(1.0 + (frequency / corner) ** 4), abs=0.08)
