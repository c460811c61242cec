"""A compliance is no better for what it does to noise, and no worse."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.signal import lfilter

from stribeck.effects.registry import effect_named
from stribeck.gap.fitted.model import Model, fit_model, referred, retune, weights_of
from stribeck.gap.fitted.noisy import put_back, quieter
from stribeck.gap.records.floor import noise_of_rows
from stribeck.gap.records.passed import BANDS, LEAST, Passed, spectrum
from stribeck.gap.records.prepare import Prepared, prepare
from stribeck.gap.records.spread import Noise
from stribeck.gap.search.rank import rank
from stribeck.identify.conditioning import Conditioned
from stribeck.identify.residual import Residual
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath

from ..conftest import NOMINAL, TRUE, recorded

SHAFT = {"stiffness": 900.0, "damping": 1.0}  # rings at 8 Hz, 3 % of critical
NOISE = 1e-4  # rad


def through(encoder: float, torque: float, bristle: bool = False, *, slow: float = 1.0) -> Passed:
    """What a model of one joint adds to its residual: of torque that is slow, a part of its own."""
    power = np.full((BANDS // 2 + 1, 1), torque**2)
    power[: BANDS // 8] *= slow**2
    return Passed(np.array([encoder]), np.array([torque]), power, np.array([bristle]))


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
    return referred(replace(prepared, noise=noise), base), base, noise.rms


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
    exact = replace(prepared, reference=through(0.03, 1.0))
    less = 0.5 * floor * np.random.default_rng(0).standard_normal(base.whole.shape)
    judged = put_back(exact, less, through(0.015, 1.0), floor)
    assert np.std(judged) == pytest.approx(floor[0], rel=0.05)


def test_a_shaft_that_only_takes_noise_gains_nothing() -> None:
    """A soft link does not follow its encoder's noise: that is none of the law's merit."""
    prepared, base, floor = seen(False)
    assert prepared.reference is not None
    part, r = 0.5, prepared.reference
    noise = replace(r, encoder=part * r.encoder, torque=part * r.torque)
    model = replace(base, noise=noise, held=part * base.held, fit=replace(base.fit, residual=part * base.fit.residual))
    assert rank(replace(prepared, reference=None), [base, model], floor, 0).overall[1] > 0.2
    assert rank(prepared, [base, model], floor, 0).overall[1] < 0.05


def test_noise_in_the_torque_counts_as_well() -> None:
    prepared, _, floor = seen(False)
    exact = replace(prepared, reference=through(0.03, 1.0))
    louder = np.hypot(floor, 0.04)
    found = quieter(exact, through(0.03, 0.5), louder)
    assert found == pytest.approx(np.hypot(0.03, 0.02) / np.hypot(0.03, 0.04))
    assert quieter(exact, through(0.06, 2.0), louder) == 1.0  # what makes more of it earns nothing by that


def test_a_gap_far_above_the_noise_is_made_larger_by_what_is_taken_of_a_torque_alone() -> None:
    """What a model takes of the encoder's noise says nothing of it; of the torque, what it takes of such a one."""
    prepared, base, floor = seen(False)
    exact = replace(prepared, reference=through(0.03, 1.0))
    loud = 100.0 * floor * np.random.default_rng(0).standard_normal(base.whole.shape)
    drifts = np.cumsum(loud, axis=0)

    def times(gap: np.ndarray, noise: Passed) -> float:
        return float(np.linalg.norm(put_back(exact, gap, noise, floor)) / np.linalg.norm(gap))

    assert times(loud, through(0.015, 1.0)) == pytest.approx(1.0, rel=0.01)
    assert times(loud, through(0.03, 0.5)) == pytest.approx(2.0, rel=0.01)
    assert times(drifts, through(0.03, 1.0, slow=0.5)) == pytest.approx(2.0, rel=0.1)
    assert times(np.diff(loud, axis=0), through(0.03, 1.0, slow=0.5)) < 1.1
    assert times(np.ones_like(loud), through(0.03, 1.0, slow=0.5)) == pytest.approx(2.0, rel=0.01)
    assert spectrum(loud[:9]).shape == spectrum(loud).shape  # fewer rows than it looks at
    assert spectrum(np.ones_like(loud))[0] > 0.0  # a constant is a torque, too
    assert times(loud, through(0.03, 2.0)) == pytest.approx(1.0)
    assert times(loud, through(0.03, 1e-4)) == pytest.approx(
        LEAST**-0.5, rel=1e-3
    )  # what hardly passes is not known so well


def test_each_run_is_restored_as_its_own_gap_is() -> None:
    """What drifts in one of them is taken there; what is fast in another, not."""
    prepared, base, floor = seen(False)
    exact = replace(prepared, reference=through(0.03, 1.0))
    first = len(prepared.fit[0].analysis_index)
    gap = 100.0 * floor * np.random.default_rng(0).standard_normal(base.whole.shape)
    gap[:first] = np.cumsum(gap[:first], axis=0)
    gap[first:] -= np.roll(gap[first:], 1, axis=0)
    judged = put_back(exact, gap, through(0.03, 1.0, slow=0.5), floor)
    slow, fast = (np.linalg.norm(judged[own]) / np.linalg.norm(gap[own]) for own in (slice(first), slice(first, None)))
    assert slow == pytest.approx(2.0, rel=0.1)
    assert fast < 1.1
    gap[first:] = 0.0
    assert np.all(put_back(exact, gap, through(0.03, 1.0, slow=0.5), floor)[first:] == 0.0)


def test_where_nothing_is_known_of_a_models_noise_nothing_is_put_back() -> None:
    """Its states have run away, or there is no noise at all."""
    prepared, base, floor = seen(False)
    gap = 100.0 * base.whole
    for told, own in ((through(0.03, 1.0), through(np.nan, np.nan)), (through(0.0, 1.0), through(0.0, 1.0))):
        exact = replace(prepared, reference=told, noise=None)
        assert quieter(exact, own, floor) == 1.0
        assert put_back(exact, gap, own, floor) == pytest.approx(gap)


def test_of_a_bristle_that_one_of_two_models_has_nothing_is_put_back() -> None:
    """It passes on less noise than the sign of a velocity, which is no merit of a compliance beside it."""
    prepared, base, floor = seen(False)
    for bristles, part in (((True, True), 0.5), ((True, False), 1.0), ((False, True), 1.0)):
        exact = replace(prepared, reference=through(0.03, 1.0, bristles[0]))
        less = through(0.015, 0.5, bristles[1])
        assert quieter(exact, less, floor) == pytest.approx(part)
        gap = 100.0 * base.whole
        assert put_back(exact, gap, less, floor) == pytest.approx(gap / part, rel=0.01)


def test_a_shaft_that_takes_random_torque_alone_is_no_better() -> None:
    """Its observer follows whatever the motion does not foretell, a drift of the torque as well."""
    prepared, _, floor = seen(False)
    rng = np.random.default_rng(3)

    def drifting(runs: Sequence[Conditioned]) -> tuple[Conditioned, ...]:
        steps = [rng.standard_normal(run.command.shape) for run in runs]
        drifts = [0.3 * lfilter([0.2], [1.0, -0.98], step, axis=0) for step in steps]
        return tuple(replace(run, command=run.command + drift) for run, drift in zip(runs, drifts, strict=True))

    shaken = replace(prepared, fit=drifting(prepared.fit), held=drifting(prepared.held))
    base = retune(shaken, floor)
    told = referred(shaken, base)
    model = with_shaft(told, base, floor, stiffness=3e5, damping=0.0)
    assert rank(shaken, [base, replace(model, noise=None)], floor, 0).overall[1] > 0.3
    assert rank(told, [base, model], floor, 0).overall[1] < 0.0


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
