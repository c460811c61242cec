"""Rows that are known to be noisy count for less, and only as long as nothing else is left in the residual."""

import numpy as np
import pytest

from stribeck.gap.records.spread import LEAST, Noise, levels, noise_power, spread

ROWS = 4000
LOUD = np.arange(ROWS) % 10 < 3  # as many rows lie near a reversal
NOISE = np.where(LOUD, 1.0, 0.1)[:, None]
FLOOR = np.sqrt(np.mean(NOISE**2, axis=0))


def drawn(gap: float) -> np.ndarray:
    rng = np.random.default_rng(0)
    return NOISE * rng.standard_normal((ROWS, 1)) + gap * rng.standard_normal((ROWS, 1))


@pytest.mark.parametrize("gap", [0.3, 2.0])
def test_spread_is_noise_and_an_even_gap(gap: float) -> None:
    """With the right noise, what is spread evenly on top is found to the precision that so many rows allow."""
    found = spread(drawn(gap), NOISE**2)
    assert found[:, 0] == pytest.approx(np.sqrt(NOISE[:, 0] ** 2 + gap**2), rel=0.03)
    assert np.mean((drawn(gap) / found) ** 2) == pytest.approx(1.0, abs=1e-4)


def test_spread_knows_no_unit() -> None:
    """Of an arm of some mN m it is as much smaller, to the last digit."""
    least = 2.0**-23
    assert (spread(least * drawn(1.0), (least * NOISE) ** 2) == least * spread(drawn(1.0), NOISE**2)).all()


def test_spread_at_the_floor_is_the_noise() -> None:
    assert (spread(0.5 * drawn(0.0), NOISE**2) == NOISE).all()
    assert (spread(np.zeros((ROWS, 1)), NOISE**2) == NOISE).all()


def test_rows_of_a_joint_that_is_held_tell_nothing() -> None:
    """Four recordings in which a brake holds the joint, beside the one in which it moves, change nothing there."""
    rows = drawn(2.0)
    braked = np.concatenate([rows, np.zeros((4 * ROWS, 1))])
    power = np.concatenate([NOISE] * 5) ** 2
    assert spread(braked, power)[:ROWS] == pytest.approx(spread(rows, NOISE**2), rel=1e-4)


@pytest.mark.parametrize("seed", range(8))
def test_noise_that_is_next_to_nothing_leaves_the_gap(seed: int) -> None:
    """Where rounding decides whether the gap alone explains the residual."""
    residual = np.random.default_rng(seed).standard_normal((ROWS, 1))
    found = spread(residual, np.full((ROWS, 1), 1e-18))
    np.testing.assert_allclose(found, np.sqrt(np.mean(residual**2)), rtol=1e-6)


def test_levels_leave_the_floor() -> None:
    """Mere noise keeps the floor's mean square, and every row of it the same."""
    level = levels(0.5 * drawn(0.0), NOISE**2, FLOOR)
    np.testing.assert_allclose(level * NOISE, FLOOR[0], rtol=1e-6)
    alike = levels(drawn(100.0), NOISE**2, FLOOR)
    np.testing.assert_allclose(alike, 1.0, rtol=1e-3)


def test_a_small_gap_in_quiet_rows_shows() -> None:
    """What rows that count alike hide: three times the noise of the quiet rows is a tenth of all the power."""
    gap = np.where(LOUD, 0.0, 0.3)[:, None] * np.sign(np.sin(np.arange(ROWS) / 40.0))[:, None]
    before, after = drawn(0.0) + gap, drawn(0.0)
    plain = 1.0 - np.sum(after**2) / np.sum(before**2)
    level = levels(after, NOISE**2, FLOOR)
    weighted = 1.0 - np.sum((after * level) ** 2) / np.sum((before * level) ** 2)
    assert plain < 0.2
    assert weighted > 0.8


def test_power_of_all_rows() -> None:
    """A floor above the known noise adds evenly; without known noise, rows are alike."""
    noise = Noise(NOISE[:1000], NOISE[1000:])
    assert noise.rms == pytest.approx(FLOOR, rel=0.02)
    assert noise.power(noise.rms) == pytest.approx(NOISE**2)
    higher = noise.power(np.sqrt(noise.rms**2 + 0.25))
    assert higher == pytest.approx(NOISE**2 + 0.25)
    assert noise_power(noise, noise.rms, 1000) == pytest.approx(NOISE[:1000] ** 2)
    told = Noise(NOISE[:1000], NOISE[1000:], NOISE**2)
    own = np.where(np.arange(ROWS) % 3, 0.25, 2.25)[:, None] * NOISE**2
    assert told.power(noise.rms, own) == pytest.approx(np.maximum(own, (LEAST * noise.rms) ** 2), rel=0.02)
    assert told.power(noise.rms, np.full_like(own, np.nan)) == pytest.approx(NOISE**2)
    assert (noise_power(None, np.array([0.2]), 5) == np.full((5, 1), 0.2**2)).all()
