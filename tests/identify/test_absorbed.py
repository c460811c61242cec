"""A law that is linear in its constants, absorbed by a residual: gone from it, and from what its parameters see."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.identify.absorbed import Absorbed
from stribeck.identify.conditioning import Conditioned, condition
from stribeck.identify.map_fit import fit
from stribeck.identify.problem import Weights
from stribeck.identify.residual import Residual
from stribeck.model.layout import values_of
from stribeck.model.path import SignalPath

from .conftest import pendulum, recorded

SHARES = np.array([0.4, -0.7])  # N m


def pushed(run: Conditioned) -> tuple[Conditioned, np.ndarray]:
    """A run with two waves in its command, over time and over position, and both by one unit (M, 1, 2)."""
    laws = np.stack([np.sin(7.0 * run.time)[:, None], np.cos(4.0 * run.position)], axis=2)
    other = replace(run, command=run.command + laws @ SHARES)
    return other, run.filtered(laws)


@pytest.fixture(scope="module")
def both() -> tuple[Residual, Residual, np.ndarray]:
    """The residual of a plain run, that of one that was pushed, and what pushed it."""
    run = condition(pendulum(), recorded(noise=2e-5), 20.0)
    path = SignalPath(pendulum(), ())
    other, columns = pushed(run)
    return Residual(path, [run]), Residual(path, [other]), columns


def test_the_law_is_gone_whatever_the_parameters(both: tuple[Residual, Residual, np.ndarray]) -> None:
    plain, whole, columns = both
    scale = np.linspace(1.0, 3.0, len(columns))[:, None]
    for factor in (1.0, 1.3):
        p = factor * values_of(plain.path.entries)
        left, same = Absorbed(whole, columns, scale)(p)[0], Absorbed(plain, columns, scale)(p)[0]
        pushed_by = whole(p)[0] - plain(p)[0]
        assert np.std(left - same) < 0.1 * np.std(pushed_by)  # not 0: what sticks takes its part of any push
        assert (scale * left).ravel() @ (scale[..., None] * columns).reshape(-1, 2) == pytest.approx(0.0, abs=1e-6)


def test_its_jacobian_is_that_of_what_is_left(both: tuple[Residual, Residual, np.ndarray]) -> None:
    _, whole, columns = both
    residual, p = Absorbed(whole, columns, np.array([2.0])), values_of(whole.path.entries)
    left, jacobian = residual(p)
    assert residual.value(p) == pytest.approx(left, abs=1e-12)
    for k, i in enumerate(residual.columns):
        step = 1e-4 * max(abs(p[i]), 0.1)
        ahead, behind = p.copy(), p.copy()
        ahead[i], behind[i] = p[i] + step, p[i] - step
        slope = (residual.value(ahead) - residual.value(behind)) / (2.0 * step)
        assert jacobian[..., k] == pytest.approx(slope, abs=2e-3 * np.abs(slope).max() + 1e-9)


def test_where_all_values_are_held_the_law_is_gone_all_the_same(both: tuple[Residual, Residual, np.ndarray]) -> None:
    _, whole, columns = both
    p = values_of(whole.path.entries)
    held = Residual(whole.path, whole.runs, ())
    left, jacobian = Absorbed(held, columns, np.array([2.0]))(p)
    assert left == pytest.approx(Absorbed(whole, columns, np.array([2.0]))(p)[0])
    assert jacobian.shape == (*left.shape, 0)


def test_a_fit_is_not_pushed_and_the_constants_come_out(both: tuple[Residual, Residual, np.ndarray]) -> None:
    plain, whole, columns = both
    weights = Weights(np.array([0.02]), np.ones(1))
    start = 1.15 * values_of(plain.path.entries)
    absorbed = Absorbed(whole, columns, weights.scale)
    free, astray, mended = (fit(r, weights, start) for r in (plain, whole, absorbed))
    assert mended.misfit < 0.02 * astray.misfit
    for key in ("A.mass", "A.friction.C0", "A.friction.C2"):
        assert mended.value(key) == pytest.approx(free.value(key), rel=0.01)
    constants = absorbed.constants(whole.value(mended.p)[..., None])[:, 0]
    assert np.abs(constants) == pytest.approx(np.abs(SHARES), rel=0.05)
