"""A compliance is no better for what it does to noise, and no worse."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from stribeck.effects.registry import effect_named
from stribeck.gap.fitted.model import Model, fit_model, noise_in, retune, weights_of
from stribeck.gap.fitted.noisy import put_back, quieter
from stribeck.gap.records.floor import noise_of_rows
from stribeck.gap.records.prepare import Prepared, prepare
from stribeck.gap.records.spread import Noise
from stribeck.gap.search.rank import rank
from stribeck.identify.residual import Residual
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath

from ..conftest import NOMINAL, TRUE, recorded

SHAFT = {"stiffness": 900.0, "damping": 1.0}  # rings at 8 Hz, 3 % of critical
NOISE = 1e-4  # rad


@cache
def seen(hidden: bool) -> tuple[Prepared, Model, np.ndarray]:
    """Recordings of a coarse encoder, their re-tuned model and what noise leaves of it, N m rms."""
    effects = [("joint_flexibility", SHAFT)] if hidden else []
    prepared = prepare(NOMINAL, recorded(*effects, noise=NOISE))
    base = retune(prepared, np.array([0.02]))
    path = SignalPath(prepared.arm, ())
    noise = Noise(*(
        noise_of_rows(prepared.arm, path, base.fit.p, runs, prepared.cutoff, 0)
        for runs in (prepared.fit, prepared.held)
    ))  # fmt: skip
    reference = noise_in(Residual(path, prepared.held, ()), base.fit.p, base.held, prepared)
    return replace(prepared, noise=noise, reference=reference), base, noise.rms


def with_shaft(prepared: Prepared, base: Model, floor: np.ndarray, **start: float) -> Model:
    weights = weights_of(base, prepared, floor)
    placed = (Placed(effect_named("joint_flexibility"), 0),)
    model = fit_model(prepared, placed, weights, base.fit, {**SHAFT, **start}, evaluations=40)
    return fit_model(prepared, model.placed, weights_of(model, prepared, floor), model.fit, evaluations=40)


def test_a_residual_without_a_compliance_stays() -> None:
    prepared, base, floor = seen(False)
    assert put_back(prepared, base.whole, base.noise, floor) == pytest.approx(base.whole)


def test_noise_that_a_model_takes_is_put_back() -> None:
    prepared, base, floor = seen(False)
    exact = replace(prepared, reference=np.array([[0.03], [1.0]]))
    less = 0.5 * floor * np.random.default_rng(0).standard_normal(base.whole.shape)
    judged = put_back(exact, less, np.array([[0.015], [1.0]]), floor)
    assert np.std(judged) == pytest.approx(floor[0], rel=0.05)


def test_a_shaft_that_only_takes_noise_gains_nothing() -> None:
    """A soft link does not follow its encoder's noise: that is none of the law's merit."""
    prepared, base, floor = seen(False)
    assert prepared.reference is not None
    part, noise = 0.5, 0.5 * prepared.reference
    model = replace(base, noise=noise, held=part * base.held, fit=replace(base.fit, residual=part * base.fit.residual))
    assert rank(replace(prepared, reference=None), [base, model], floor, 0).overall[1] > 0.2
    assert rank(prepared, [base, model], floor, 0).overall[1] < 0.05


def test_noise_in_the_torque_counts_as_well() -> None:
    prepared, _, floor = seen(False)
    exact = replace(prepared, reference=np.array([[0.03], [1.0]]))
    louder = np.hypot(floor, 0.04)
    found = quieter(exact, np.array([[0.03], [0.5]]), louder)
    assert found == pytest.approx(np.hypot(0.03, 0.02) / np.hypot(0.03, 0.04))
    assert quieter(exact, np.array([[0.06], [2.0]]), louder) == 1.0  # what makes more of it earns nothing by that


def test_a_gap_far_above_the_noise_is_not_made_larger() -> None:
    prepared, base, floor = seen(False)
    exact = replace(prepared, reference=np.array([[0.03], [1.0]]))
    loud = 100.0 * base.whole
    judged = put_back(exact, loud, np.array([[0.015], [1.0]]), floor)
    assert np.std(judged) == pytest.approx(np.std(loud), rel=0.01)


def test_a_shaft_that_is_there_keeps_its_gain_and_its_damping() -> None:
    prepared, base, floor = seen(True)
    model = with_shaft(prepared, base, floor, stiffness=600.0, damping=8.0)
    found = model.placed[0].values
    assert rank(prepared, [base, model], floor, 0).overall[1] > 0.8
    assert found["stiffness"] == pytest.approx(SHAFT["stiffness"], rel=0.05)
    assert found["damping"] == pytest.approx(SHAFT["damping"], rel=0.5)


def test_the_observer_keeps_noise_from_ringing_on() -> None:
    """At the true values noise near the link's own frequency would come out many times as large."""
    prepared, _, _ = seen(True)
    exact = replace(prepared, arm=TRUE)
    path = SignalPath(exact.arm, (Placed(effect_named("joint_flexibility"), 0, SHAFT),))
    alone, observed = (
        np.std(Residual(path, exact.fit, (), observe=observe)(values_of(path.entries))[0]) for observe in (False, True)
    )
    assert observed < 0.5 * alone
