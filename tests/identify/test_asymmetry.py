"""One friction curve or two: equal directions are fitted as one, different ones told apart."""

import math

import numpy as np
import pytest

from stribeck.identify.asymmetry import common_curve, compare_curves
from stribeck.identify.tustin_fit import fit_curve, tustin

TRUE = np.array([5.0, 1.25, 1.5, 0.05])
SPEED = np.concatenate([np.repeat(np.geomspace(0.01, 1.0, 10), 4), np.zeros(10)])


def readings(rng: np.random.Generator, factor: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    return SPEED, factor * tustin(TRUE, SPEED) * (1.0 + 0.05 * rng.standard_normal(len(SPEED)))


def test_equal_directions_are_not_told_apart() -> None:
    rng = np.random.default_rng(1)
    same = [readings(rng), readings(rng)]
    assert compare_curves(same) > 0.01
    assert compare_curves([same[0], readings(rng, 0.9)]) < 1e-4


@pytest.mark.long
def test_the_probability_means_what_it_says() -> None:
    """Of equal directions a tenth lies below 0.1."""
    rng = np.random.default_rng(2)
    chances = np.array([compare_curves([readings(rng), readings(rng)]) for _ in range(60)])
    assert 0.02 < np.mean(chances < 0.1) < 0.25
    assert 0.3 < np.mean(chances < 0.5) < 0.7


def test_a_common_curve_is_the_fit_to_all_readings() -> None:
    rng = np.random.default_rng(3)
    sets = [readings(rng), readings(rng)]
    found = common_curve(sets)
    assert found.points == 2 * len(SPEED)
    assert found.constants == pytest.approx(
        fit_curve(np.tile(SPEED, 2), np.concatenate([f for _, f in sets])).constants
    )
    assert found.level_sd(SPEED).mean() < fit_curve(*sets[0]).level_sd(SPEED).mean()


def test_exact_readings_have_nothing_to_compare() -> None:
    exact = (SPEED[:3], tustin(TRUE, SPEED[:3]))
    assert math.isnan(compare_curves([exact, exact]))
