"""A compliance is no better for what it does to noise, and no worse."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from stribeck.effects.registry import effect_named
from stribeck.gap.floor import noise_of_rows
from stribeck.gap.model import Model, fit_model, retune, weights_of
from stribeck.gap.noisy import comparable
from stribeck.gap.prepare import Prepared, prepare
from stribeck.gap.rank import rank
from stribeck.gap.spread import Noise
from stribeck.identify.residual import Residual
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath

from .conftest import NOMINAL, TRUE, recorded

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
    return replace(prepared, noise=noise), base, noise.rms


def with_shaft(prepared: Prepared, base: Model, floor: np.ndarray, **start: float) -> Model:
    weights = weights_of(base.fit.residual, prepared, floor)
    placed = (Placed(effect_named("joint_flexibility"), 0),)
    model = fit_model(prepared, placed, weights, base.fit, {**SHAFT, **start}, evaluations=40)
    return fit_model(prepared, model.placed, weights_of(model.fit.residual, prepared, floor), model.fit, evaluations=40)


def test_residuals_without_a_compliance_stay() -> None:
    prepared, base, floor = seen(False)
    (plain, again) = comparable(prepared, [base, base], floor)
    assert plain == pytest.approx(np.concatenate([base.fit.residual, base.held]))
    assert again == pytest.approx(plain)


def test_a_shaft_that_only_takes_noise_gains_nothing() -> None:
    """A soft link does not follow its encoder's noise: that is none of the law's merit."""
    prepared, base, floor = seen(False)
    weights = weights_of(base.fit.residual, prepared, floor)
    placed = (Placed(effect_named("joint_flexibility"), 0),)
    model = fit_model(prepared, placed, weights, base.fit, {"stiffness": 700.0, "damping": 1.0}, evaluations=1)
    assert base.noise is not None
    assert model.noise is not None
    assert model.noise[0] < 0.8 * base.noise[0]
    plain, judged = np.concatenate([model.fit.residual, model.held]), comparable(prepared, [base, model], floor)[1]
    assert judged == pytest.approx(plain * base.noise[0] / model.noise[0], rel=1e-3)


def test_noise_in_the_torque_counts_as_well() -> None:
    prepared, base, floor = seen(False)
    model = replace(base, placed=(Placed(effect_named("joint_flexibility"), 0),), noise=np.array([[0.03], [0.5]]))
    stiff = replace(base, noise=np.array([[0.03], [1.0]]))
    louder = np.hypot(floor, 0.04)
    judged = comparable(prepared, [stiff, model], louder)[1]
    assert judged[-1] == pytest.approx(base.held[-1] * np.hypot(0.03, 0.04) / np.hypot(0.03, 0.02))


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
