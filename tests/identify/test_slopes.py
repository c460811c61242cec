"""Derivatives that follow a fit's steps: seldom taken, and taken again where they do not hold."""

from collections.abc import Callable

import numpy as np
import pytest

from stribeck.identify.slopes import Slopes


class Curve:
    """A problem of two values, and how often its derivatives were asked for."""

    def __init__(self, squared: Callable[[np.ndarray], np.ndarray]) -> None:
        self.squared, self.asked = squared, 0

    def slopes(self, z: np.ndarray) -> np.ndarray:
        self.asked += 1
        width = 1e-6 * np.eye(len(z))
        return np.stack([(self.squared(z + w) - self.squared(z - w)) / 2e-6 for w in width], axis=1)


def line(z: np.ndarray) -> np.ndarray:
    return np.array([2.0 * z[0] + z[1] - 1.0, z[0] - z[1], 0.5 * z[1]])


def bent(z: np.ndarray) -> np.ndarray:
    return np.array([z[0] + 0.3 * z[0] ** 2 - 1.0, z[1] * (1.0 + 0.2 * z[0])])


def test_of_a_line_they_are_taken_once() -> None:
    problem = Curve(line)
    slopes = Slopes(problem)
    first = slopes(np.array([3.0, 2.0]))
    slopes.squared(np.array([1.0, 1.0]))
    assert slopes(np.array([1.0, 1.0])) == pytest.approx(first, abs=1e-8)
    assert (problem.asked, slopes.own) == (1, False)


def test_they_hold_along_the_step_that_was_made() -> None:
    """Broyden's condition: what the step has changed is what they say of it."""
    problem = Curve(bent)
    slopes = Slopes(problem)
    start, end = np.array([2.0, 1.0]), np.array([1.2, 0.2])
    slopes(start)
    followed = slopes(end)
    assert not slopes.own
    assert followed @ (end - start) == pytest.approx(bent(end) - bent(start))


def test_where_the_cost_falls_by_far_less_than_foretold_they_are_taken_anew() -> None:
    problem = Curve(lambda z: np.array([z[0] if z[0] > 1.0 else 2.0 - z[0]]))
    slopes = Slopes(problem)
    slopes(np.array([3.0]))
    there = slopes(np.array([-0.5]))
    assert slopes.own
    assert there == pytest.approx(-1.0)


def test_forgotten_they_are_taken_anew() -> None:
    problem = Curve(line)
    slopes = Slopes(problem)
    slopes(np.array([3.0, 2.0]))
    slopes.forget()
    slopes(np.array([1.0, 1.0]))
    assert (problem.asked, slopes.own) == (2, True)


def test_what_runs_away_is_infinite() -> None:
    assert np.all(np.isinf(Slopes(Curve(lambda z: np.array([1e200 * z[0], 1.0]))).squared(np.array([2.0]))))
