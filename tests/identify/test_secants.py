"""Secants in a derivative's place: the same where the law is smooth, and the way to a play's width where it is not."""

from collections.abc import Sequence

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from stribeck.effects.registry import registry
from stribeck.identify.conditioning import condition
from stribeck.identify.map_fit import fit
from stribeck.identify.problem import Weights
from stribeck.identify.residual import Residual
from stribeck.identify.secants import Secants
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath

from .conftest import pendulum, recorded

SMOOTH = (
    Placed(registry()["joint_flexibility"], 0, {"stiffness": 60.0, "damping": 0.8}),
    Placed(registry()["actuator_lag"], 0, {"time_constant": 0.02}),
)


def test_narrow_secants_are_derivatives() -> None:
    """By logarithms as well; along runs of different rates."""
    runs = [condition(pendulum(), recorded(rate=rate, duration=3.0, noise=1e-5), 20.0) for rate in (250.0, 500.0)]
    path = SignalPath(pendulum(), SMOOTH)
    p = values_of(path.entries)
    steps = np.array(
        [1e-5 if entry.log else 1e-5 * max(abs(value), 0.1) for entry, value in zip(path.entries, p, strict=True)]
    )
    exact, secants = Residual(path, runs), Secants(path, runs, steps)
    (r, jacobian), (same, approximate) = exact(p), secants(p)
    assert same == pytest.approx(r, abs=1e-12)
    assert secants.value(p) == pytest.approx(r, abs=1e-12)
    scale = np.abs(jacobian).max(axis=(0, 1))
    assert (scale > 0.0).all()
    assert approximate / scale == pytest.approx(jacobian / scale, abs=1e-3)
    again = secants.along(runs[:1])(p)[1]
    assert again == pytest.approx(approximate[: len(again)], abs=1e-9 * scale.max())


def test_a_delay_moves_the_record_under_its_secant() -> None:
    run = condition(pendulum(), recorded(duration=3.0, noise=1e-5), 20.0)
    path = SignalPath(pendulum(), [SMOOTH[0], Placed(registry()["delay"], 0, {"time": 0.013})])
    p = values_of(path.entries)
    late = [i for i, entry in enumerate(path.entries) if entry.name == "time"]
    residual = Secants(path, [run], np.full(len(p), 0.002), late)
    ahead, behind = p.copy(), p.copy()
    ahead[late], behind[late] = 0.015, 0.011
    secant = (Residual(path, [run], ())(ahead)[0] - Residual(path, [run], ())(behind)[0]) / 0.004
    assert residual(p)[1][..., 0] == pytest.approx(secant, abs=1e-9 * np.abs(secant).max())


class Watched(Secants):
    """Remembers what it evaluates."""

    def _values(self, trials: Sequence[np.ndarray]) -> list[np.ndarray]:
        self.trials = np.array(trials)
        return super()._values(trials)


@pytest.mark.parametrize("ratio", [0.0, 0.05, 0.9])
def test_secants_stay_within_bounds(ratio: float) -> None:
    """At a bound there is one to the other side; where both ends are the bound there is none."""
    run = condition(pendulum(), recorded(duration=3.0), 20.0)
    path = SignalPath(pendulum(), [Placed(registry()["load_dependent_friction"], 0, {"ratio": ratio})])
    p = values_of(path.entries)
    (own,) = [i for i, entry in enumerate(path.entries) if entry.owner == 0]
    entry = path.entries[own]
    secants = Watched(path, [run], np.full(len(p), 0.1), [own])
    _, jacobian = secants(p)
    assert entry.lower <= secants.trials[:, own].min() < secants.trials[:, own].max() <= entry.upper
    exact = Residual(path, [run], [own])(p)[1]
    assert jacobian == pytest.approx(exact, abs=0.2 * np.abs(exact).max())
    assert not Secants(path, [run], np.zeros(len(p)), [own])(p)[1].any()


class Rough(Residual):
    """A residual with a cost that is rough all over: a fit by its derivatives goes nowhere."""

    dear = True
    calls = 0

    def __call__(self, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        self.calls += 1
        r, jacobian = super().__call__(p)
        return r, jacobian * (-1.0 if self.calls % 2 else 1.0)

    def value(self, p: np.ndarray) -> np.ndarray:
        return super().__call__(p)[0]


def test_a_fit_that_leads_nowhere_ends_and_says_so() -> None:
    """And gives the best that it met."""
    run = condition(pendulum(), recorded(duration=3.0, noise=1e-5), 20.0, np.full(1, 1e-5))
    path = SignalPath(pendulum(), [Placed(registry()["actuator_lag"], 0, {"time_constant": 0.02})])
    weights = Weights(np.full(1, 0.01), np.ones(1))
    rough = Rough(path, [run])
    found = fit(rough, weights)
    assert found.status == "No_Further_Descent"
    assert rough.calls < 40
    start = rough.value(values_of(path.entries))
    assert found.cost <= 0.5 * float(np.sum((start * weights.scale) ** 2)) * (1.0 + 1e-6)


def test_drives_that_stay_late_are_made_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """And what is kept along them is kept for all evaluations."""
    run = condition(pendulum(), recorded(duration=2.0, noise=1e-5), 20.0)
    late = Placed(registry()["delay"], 0, {"time": 0.01})
    path = SignalPath(pendulum(), [late, Placed(registry()["load_dependent_friction"], 0, {"ratio": 0.1})])
    p = values_of(path.entries)
    own = [i for i, entry in enumerate(path.entries) if entry.owner == 1]
    secants = Secants(path, [run], np.full(len(p), 0.1), own)
    first = secants(p)
    (known,) = secants._kept[frozenset()]._of
    monkeypatch.setattr(CubicSpline, "__init__", None)
    again = secants(p)
    assert list(secants._kept[frozenset()]._of) == [known]
    assert all((one == other).all() for one, other in zip(first, again, strict=True))
