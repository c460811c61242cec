"""The fit of Tustin's curve: exact on exact readings, intervals that hold, failures that are said."""

from functools import cache

import numpy as np
import pytest

from stribeck.identify.tustin_fit import CurveFit, fit_curve, tustin

A, B = np.array([5.0, 1.25, 1.5, 0.05]), np.array([2.2, 0.6, 0.8, 0.04])
SPEEDS = np.array([0.0075, 0.015, 0.03, 0.05, 0.075, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0])
PAPER = np.concatenate([np.repeat(SPEEDS, 4), np.zeros(10)])
GRID = np.geomspace(0.0075, 1.0, 100)


@cache
def draws(true: tuple[float, ...]) -> list[CurveFit]:
    """Forty fits to readings at the paper's conditions."""
    return [fit_curve(PAPER, noisy(np.array(true), seed)) for seed in range(40)]


def noisy(true: np.ndarray, seed: int, share: float = 0.05) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return tustin(true, PAPER) * (1.0 + share * rng.standard_normal(len(PAPER)))


@pytest.mark.parametrize("true", [A, B, np.array([0.5, 3.0, 0.1, 0.2]), np.array([100.0, 10.0, 30.0, 0.02])])
def test_exact_readings_give_the_constants(true: np.ndarray) -> None:
    found = fit_curve(PAPER, tustin(true, PAPER))
    assert found.ok
    assert found.constants == pytest.approx(true, rel=1e-5)
    assert found.identified.all()
    assert found.scatter < 1e-6


def test_units_do_not_matter() -> None:
    """A thousand times the torque, and ten times the velocity, give the same curve in those units."""
    torque = noisy(A, 3)
    one, other = fit_curve(PAPER, torque), fit_curve(10.0 * PAPER, 1000.0 * torque)
    assert other.constants == pytest.approx(one.constants * [1000.0, 1000.0, 100.0, 10.0], rel=1e-4)
    assert other.low == pytest.approx(one.low * [1000.0, 1000.0, 100.0, 10.0], rel=1e-3)


def test_is_the_least_squares_minimum() -> None:
    torque = noisy(A, 4)
    found = fit_curve(PAPER, torque)
    size = tustin(found.constants, PAPER)

    def cost(constants: np.ndarray) -> float:
        return float(np.sum(((torque - tustin(constants, PAPER)) / size) ** 2))

    for i in range(4):
        for step in (-1e-3, 1e-3):
            nearby = found.constants.copy()
            nearby[i] *= 1.0 + step
            assert cost(nearby) > cost(found.constants)


def test_curve_error_and_coverage_at_the_paper_s_conditions() -> None:
    """Forty draws a joint here; the study `identification` does 200."""
    for true in (A, B):
        fits = draws(tuple(true))
        assert all(fit.ok for fit in fits)
        error = [np.sqrt(np.mean((fit.level(GRID) / tustin(true, GRID) - 1.0) ** 2)) for fit in fits]
        assert np.median(error) < 0.015
        assert np.mean(np.array(error) < 0.02) > 0.85
        covered = np.mean([(fit.low <= true) & (true <= fit.high) for fit in fits], axis=0)
        assert (covered >= 0.85).all()
        assert np.mean([fit.scatter for fit in fits]) == pytest.approx(0.05, rel=0.05)


@pytest.mark.parametrize("share", [1e-6, 1e-3])
def test_intervals_are_as_wide_as_the_readings_scatter(share: float) -> None:
    """However little that is: intervals are narrower in proportion, and hold as well."""
    fine, coarse = ([fit_curve(PAPER, noisy(A, seed, one)) for seed in range(20)] for one in (share, 3e-3))
    widths = [np.mean([fit.high - fit.low for fit in fits], axis=0) for fits in (fine, coarse)]
    assert widths[0] / share == pytest.approx(widths[1] / 3e-3, rel=0.02)
    assert (np.mean([(fit.low <= A) & (fit.high >= A) for fit in fine], axis=0) >= 0.8).all()


def test_the_band_is_the_spread_of_the_curve() -> None:
    fits = draws(tuple(A))
    spread = np.std([fit.level(GRID) for fit in fits], axis=0)
    stated = np.mean([fit.level_sd(GRID) for fit in fits], axis=0)
    assert stated == pytest.approx(spread, rel=0.35)


def test_no_bend_is_said_to_be_undetermined() -> None:
    """Coulomb and viscous friction alone: C0 and C2 are found, C1 reaches zero and alpha anything."""
    true = np.array([3.0, 0.0, 0.7, 0.05])
    found = fit_curve(PAPER, noisy(true, 1, 0.01))
    assert found.ok
    assert found.constants[[0, 2]] == pytest.approx([3.0, 0.7], rel=0.1)
    assert found.low[1] == 0.0
    assert not found.identified[1]
    assert not found.identified[3]


@pytest.mark.parametrize("speed", [[], [0.0] * 8, [0.1, 0.2, 0.3], [0.1] * 10, [0.0, 0.1, 0.2] * 4])
def test_too_few_readings(speed: list[float]) -> None:
    found = fit_curve(np.array(speed), tustin(A, np.array(speed)))
    assert not found.ok
    assert found.status == "too_few_readings"
    assert np.isnan(found.constants).all()
    assert not found.identified.any()


def test_slow_speeds_of_a_stage_are_told_apart() -> None:
    """From 5 to 120 µm/s, as an axis in m has them."""
    true = (2.0, 1.0, 900.0, 2e-5)
    speed = np.repeat(np.geomspace(5e-6, 1.2e-4, 10), 2)
    assert fit_curve(speed, tustin(true, speed)).ok
