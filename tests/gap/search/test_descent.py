"""The way down from a candidate's start."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stribeck.gap.search.descent import Descent

ENTRIES = [SimpleNamespace(log=False, lower=-10.0, upper=10.0), SimpleNamespace(log=True, lower=1e-3, upper=50.0)]


class Valley:
    """Left of a law of two values, one of them a logarithm: nothing at (3, 20)."""

    def __init__(self) -> None:
        self.path, self.met = SimpleNamespace(entries=ENTRIES), []  # type: ignore[var-annotated]

    def __call__(self, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        self.met.append(p)
        return np.array([p[0] - 3.0, p[1] - 20.0]), np.eye(2)


class Plain:
    """Saves what is less than 1000 of half the squares, nothing else to follow."""

    def step(self, r: np.ndarray, jacobian: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        return 1000.0 - 0.5 * float(r @ r), jacobian.T @ jacobian, jacobian.T @ r


def way(valley: Any) -> Descent:
    return Descent(valley, Plain(), np.array([0.0, 1.0]), [0, 1], np.ones(2))  # type: ignore[arg-type]


def test_it_goes_on_from_where_it_is() -> None:
    """No place is evaluated twice, and a way in two parts is the way in one."""
    apart, whole = Valley(), Valley()
    first, other = way(apart), way(whole)
    first.go(2)
    between = first.saved
    first.go(10)
    other.go(12)
    assert between < first.saved == other.saved
    np.testing.assert_array_equal(apart.met, whole.met)
    assert len(np.unique(apart.met, axis=0)) == len(apart.met) < 12  # it ends where a step promises little
    assert first.p == pytest.approx([3.0, 20.0], rel=0.1)


def test_what_a_logarithm_foresees_is_no_more_than_e_times() -> None:
    valley = Valley()
    way(valley).go(3)
    values = np.array(valley.met)[:, 1]
    assert values[0] == 1.0
    assert np.all(values[1:] / values[:-1] <= np.e * (1 + 1e-12))


def test_bounds_are_kept() -> None:
    class Slope(Valley):
        def __call__(self, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            self.met.append(p)
            return np.array([p[0] - 30.0, 0.0]), np.array([[1.0], [0.0]])

    valley: Any = Slope()
    descent = Descent(valley, Plain(), np.array([0.0, 1.0]), [0], np.ones(1))  # type: ignore[arg-type]
    descent.go(3)
    assert descent.p[0] == ENTRIES[0].upper
    assert np.max(np.array(valley.met)[:, 0]) == ENTRIES[0].upper
