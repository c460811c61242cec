"""A fit within a trust region: it gets through wrinkles, stays within bounds, and says how it ended."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.arm import Tolerance
from stribeck.identify import slopes as slopes_module
from stribeck.identify.conditioning import condition
from stribeck.identify.map_fit import fit
from stribeck.identify.problem import Problem, Weights
from stribeck.identify.residual import Residual
from stribeck.model.layout import values_of
from stribeck.model.path import SignalPath

from .conftest import PENDULUM, pendulum, recorded, stronger

WEIGHTS = Weights(np.array([0.05]), np.array([4.0]))


def residual(**changes: float) -> Residual:
    path = SignalPath(replace(pendulum(), tolerance=Tolerance(0.3, 1.0)))
    return Residual(
        path, [condition(pendulum(), recorded(stronger(PENDULUM, **changes), rate=250.0, noise=1e-5), 20.0)]
    )


class Wrinkled(Residual):
    """Its values go up and down by wrinkles of which its derivatives tell nothing."""

    dear = True

    def __call__(self, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        r, jacobian = super().__call__(p)
        return r * (1.0 + 0.02 * np.sin(3e3 * p.sum())), jacobian


def test_ends_where_ipopt_does_when_derivatives_are_true() -> None:
    smooth, dear = residual(C0=1.5, mass=1.1), residual(C0=1.5, mass=1.1)
    dear.dear = True
    one, other = fit(smooth, WEIGHTS), fit(dear, WEIGHTS)
    assert one.ok
    assert other.ok
    assert other.cost == pytest.approx(one.cost, rel=1e-3)
    scale = np.array([entry.sd for entry in one.entries])[one.free]
    assert (other.p - one.p)[one.free] / scale == pytest.approx(0.0, abs=0.02)


def test_slopes_that_are_always_believed_are_taken_anew_before_it_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(slopes_module, "TRUE", -1e9)
    smooth, dear = residual(C0=1.5, mass=1.1), residual(C0=1.5, mass=1.1)
    dear.dear = True
    taken: list[np.ndarray] = []
    slopes = Problem.slopes

    def counted(problem: Problem, z: np.ndarray) -> np.ndarray:
        taken.append(z)
        return slopes(problem, z)

    monkeypatch.setattr(Problem, "slopes", counted)
    found = fit(dear, WEIGHTS)
    assert found.cost == pytest.approx(fit(smooth, WEIGHTS).cost, rel=1e-3)
    assert found.ok
    assert 2 <= len(taken) <= 6
    assert len({z.tobytes() for z in taken}) == len(taken)


def test_gets_through_wrinkles_and_never_above_its_start() -> None:
    plain = residual(C0=1.5, mass=1.1)
    wrinkled = Wrinkled(plain.path, plain.runs)
    nominal = values_of(plain.path.entries)
    start, end = (0.5 * np.sum(plain.value(p) ** 2) for p in (nominal, fit(plain, WEIGHTS).p))
    found = fit(wrinkled, WEIGHTS)
    assert 0.5 * np.sum(plain.value(found.p) ** 2) < end + 0.05 * (start - end)
    good = fit(wrinkled, WEIGHTS, found.p)
    assert good.cost <= found.cost * (1.0 + 1e-6)


def test_stays_within_its_limits() -> None:
    """Friction that the recording would have below zero."""
    dear = residual(C0=0.0)
    dear.dear = True
    found = fit(dear, WEIGHTS)
    assert all(e.lower <= v <= e.upper for v, e in zip(found.p, found.entries, strict=True))
    assert found.value("A.friction.C0") < 0.3


def test_evaluations_that_do_not_do_are_told() -> None:
    dear = residual(C0=1.5, mass=1.3)
    dear.dear = True
    found = fit(dear, WEIGHTS, evaluations=1)
    assert not found.ok
    assert found.status == "Maximum_Iterations_Exceeded"
    assert np.isfinite(found.cost)
