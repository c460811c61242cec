"""What noise adds to a residual: nothing where there is none, as much as the record's own, with its derivatives."""

from __future__ import annotations

import numpy as np
import pytest

from stribeck.identify.added import Added
from stribeck.identify.conditioning import condition
from stribeck.identify.noise_pull import louder
from stribeck.identify.residual import Residual
from stribeck.model.layout import values_of
from stribeck.model.path import SignalPath

from .conftest import PENDULUM, hoisted, pendulum, recorded

CUTOFF = 20.0
PATH = SignalPath(pendulum())
P = values_of(PATH.entries)


def added(noise: float) -> tuple[Residual, Added]:
    run = condition(pendulum(), recorded(rate=250.0, noise=noise), CUTOFF, np.full(1, noise), thin=True)
    residual = Residual(PATH, [run])
    return residual, Added(residual, P, louder(residual, CUTOFF))


def test_it_grows_with_the_noise_from_nothing() -> None:
    small, large = (np.sqrt(np.sum(added(noise)[1](P)[0] ** 2)) for noise in (1e-12, 1e-4))
    assert small < 1e-6 * large


def test_it_is_as_much_as_the_record_s_own_noise_leaves_in_motion() -> None:
    residual, own = added(1e-4)
    moving = np.abs(residual.runs[0].velocity[residual.runs[0].analysis_index, 0]) > 0.5
    left, again = residual.value(P)[moving], own(P)[0][:, moving]
    assert np.sum(again**2) == pytest.approx(np.sum(left**2), rel=0.2)


def test_its_jacobian_is_its_derivative_and_friction_has_none() -> None:
    """But for the few rows next to a reversal, where friction bends."""
    residual, own = added(1e-4)
    rows, slopes = own(P)
    for k, i in enumerate(residual.columns):
        step = np.zeros(len(P))
        step[i] = 1e-4 * P[i]
        change = (own(P + step)[0] - own(P - step)[0]) / (2.0 * step[i])
        assert np.quantile(np.abs(change - slopes[..., k]), 0.98) < 1e-3 * np.abs(rows).max() / P[i]
        assert (PATH.entries[i].owner == "friction") == (not slopes[..., k].any()) == (not change.any())


def test_a_weight_that_friction_bears_as_well_adds_nothing() -> None:
    """Mass that is taken for the rotor's changes the weight of a vertical axis, and not what it accelerates."""
    arm, run = hoisted(PENDULUM, noise=1e-5)
    path = SignalPath(arm)
    residual = Residual(path, [condition(arm, run, CUTOFF, np.full(1, 1e-5), thin=True)])
    p = values_of(path.entries)
    own = Added(residual, p, louder(residual, CUTOFF))
    keys = [entry.key for entry in path.entries]
    moved = p.copy()
    moved[[keys.index("A.mass"), keys.index("A.rotor_inertia")]] += 0.03, -0.03
    assert own(moved)[0] == pytest.approx(own(p)[0], abs=1e-9 * np.abs(own(p)[0]).max())
