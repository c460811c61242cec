"""Secants for the lateness of a record: the way from far, which derivatives do not find where friction leaps."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.effects.registry import registry
from stribeck.identify.conditioning import Conditioned, condition
from stribeck.identify.map_fit import fit
from stribeck.identify.problem import Weights
from stribeck.identify.residual import Residual
from stribeck.identify.shifted import Shifted
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath

from .conftest import pendulum, recorded

EARLY = -0.032  # s


def late(start: float) -> tuple[SignalPath, np.ndarray, int]:
    path = SignalPath(pendulum(), [Placed(registry()["time_shift"], 0, {"time": start})])
    (own,) = path.shifts
    return path, values_of(path.entries), own


def early_record(noise: float = 2e-5) -> Conditioned:
    """A recording whose position is early, a whole number of samples."""
    run, samples = recorded(rate=500.0, duration=8.0, noise=noise), round(-EARLY * 500.0)
    return condition(pendulum(), replace(run, t=run.t[:-samples], q=run.q[samples:], tau=run.tau[:-samples]), 20.0)


def test_the_column_is_a_central_secant_and_others_are_derivatives() -> None:
    run = early_record()
    path, p, own = late(0.01)
    residual = Shifted(path, [run], {own: 0.005})
    r, jacobian = residual(p)
    plain = Residual(path, [run])
    exact, derivatives = plain(p)
    assert r == pytest.approx(exact, abs=1e-12)
    assert residual.value(p) == pytest.approx(exact, abs=1e-12)
    ahead, behind = p.copy(), p.copy()
    ahead[own], behind[own] = 0.015, 0.005
    k = residual.columns.index(own)
    secant = (plain(ahead)[0] - plain(behind)[0]) / 0.01
    assert jacobian[..., k] == pytest.approx(secant, abs=1e-9 * np.abs(secant).max())
    others = [i for i in range(len(residual.columns)) if i != k]
    assert jacobian[..., others] == pytest.approx(derivatives[..., others], abs=1e-12)


def test_along_another_run_it_is_that_runs() -> None:
    first, other = early_record(), early_record(noise=3e-4)
    path, p, own = late(0.01)
    moved, fresh = (
        Shifted(path, [first], {own: 0.005}).along([other]),
        Shifted(path, [other], {own: 0.005}),
    )
    assert moved(p)[1] == pytest.approx(fresh(p)[1], abs=1e-12)
    assert moved.value(p) == pytest.approx(fresh.value(p), abs=1e-12)
    assert np.abs(moved(p)[1] - Shifted(path, [first], {own: 0.005})(p)[1]).max() > 1e-3


def test_a_secant_ends_at_a_bound() -> None:
    run = early_record()
    path, p, own = late(0.2)
    p[own] = path.entries[own].upper
    jacobian = Shifted(path, [run], {own: 0.005}, [own])(p)[1]
    behind = p.copy()
    behind[own] -= 0.005
    plain = Residual(path, [run], ())
    assert jacobian[..., 0] == pytest.approx((plain(p)[0] - plain(behind)[0]) / 0.005, rel=1e-9, abs=1e-6)


@pytest.mark.parametrize("start", [-0.05, -0.015, 0.005, 0.03])
def test_a_fit_finds_an_early_record_from_far(start: float) -> None:
    """To a sixth of a sample; by derivatives at a point one ends almost half a sample away."""
    run = early_record(noise=2e-4)
    path, _, own = late(start)
    weights = Weights(np.full(1, 0.02), np.full(1, 10.0))
    found = fit(Shifted(path, [run], {own: 0.0025}), weights, scales={path.entries[own].key: 0.025})
    assert found.p[own] == pytest.approx(EARLY, abs=3.5e-4)
