"""What noise does row by row in a model's own residual: it pulls at a bristle while the joint rests."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from stribeck.effects.registry import laws, registry
from stribeck.gap.fitted.model import (
    Bristled,
    Model,
    fit_model,
    noise_in_rows,
    referred,
    retune,
    start_values,
    weights_of,
)
from stribeck.gap.fitted.noisy import quieter
from stribeck.gap.records.floor import noise_of_rows
from stribeck.gap.records.prepare import Prepared, prepare
from stribeck.gap.records.spread import Noise, noise_power
from stribeck.gap.search.rank import rank
from stribeck.identify.residual import Residual
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath
from stribeck.withheld.example import example_runs, nominal_arm

from ..conftest import NOMINAL, recorded

STIFFNESS, NOISE = 2000.0, 1e-4  # N m/rad, rad


@cache
def seen() -> tuple[Prepared, Model, np.ndarray]:
    """Recordings of a coarse encoder with the noise of their rows, the re-tuned model, and which rows are at rest."""
    prepared = prepare(NOMINAL, recorded(noise=NOISE))
    base = retune(prepared, np.array([0.02]))
    noise = Noise(*(
        noise_of_rows(prepared.arm, SignalPath(prepared.arm, ()), base.fit.p, runs, prepared.cutoff, 0)
        for runs in (prepared.fit, prepared.held)
    ))  # fmt: skip
    stuck = np.concatenate([run.stuck[run.analysis_index, 0] for run in (*prepared.fit, *prepared.held)])
    drawn = noise_in_rows(
        Residual(SignalPath(prepared.arm, ()), prepared.held, ()), base.fit.p, base.whole, prepared.moved
    )
    return replace(prepared, noise=replace(noise, drawn=drawn)), base, stuck.astype(bool)


def floor_of(prepared: Prepared) -> np.ndarray:
    assert prepared.noise is not None
    return prepared.noise.rms


def drawn_of(prepared: Prepared) -> np.ndarray:
    assert prepared.noise is not None
    assert prepared.noise.drawn is not None
    return prepared.noise.drawn


def with_residual(model: Model, residual: np.ndarray) -> Model:
    fitted = len(model.fit.residual)
    return replace(model, fit=replace(model.fit, residual=residual[:fitted]), held=residual[fitted:])


def bristle(law: str) -> Placed:
    return Placed(laws()["presliding", law], 0, {"stiffness": STIFFNESS, "damping": 0.0})


@pytest.mark.parametrize("law", ["lugre", "maxwell_slip"])
def test_a_bristle_takes_up_the_noise_of_a_joint_at_rest(law: str) -> None:
    """Where friction by itself takes up any torque, and adds nothing; in motion both add the same.

    So it does where the torque tells the bristle what it holds: no noise may hide in that.
    """
    prepared, base, stuck = seen()
    path = SignalPath(prepared.arm, (bristle(law),))
    p = values_of(path.entries)
    p[: len(base.fit.p)] = base.fit.p

    def noise_with(rows: np.ndarray | None) -> np.ndarray:
        return np.sqrt(noise_power(prepared.noise, floor_of(prepared), len(base.whole), rows)[:, 0])

    told = {}
    for observe in (False, True):
        judged = Residual(path, prepared.held, (), observe=observe)
        whole = np.concatenate([judged.along(runs)(p)[0] for runs in (prepared.fit, prepared.held)])
        told[observe] = noise_with(noise_in_rows(judged, p, whole, prepared.moved))
    plain = noise_with(None)
    for own in told.values():
        assert np.median(own[stuck]) > 2.0 * np.median(plain[stuck])
        assert np.median(own[~stuck]) == pytest.approx(np.median(plain[~stuck]), rel=0.2)


def test_a_model_with_states_knows_its_rows() -> None:
    prepared, base, _ = seen()
    weights = weights_of(base, prepared, floor_of(prepared))
    assert base.rows is None
    model = fit_model(prepared, (bristle("lugre"),), weights, base.fit, evaluations=2)
    assert model.rows is not None
    assert model.rows.shape == model.whole.shape


def test_a_law_that_is_weak_near_rest_is_no_less_noisy_there() -> None:
    """It would gain by what the noise does to the sign of a velocity, which a contact that gives does not have."""
    prepared, base, _ = seen()
    drawn = drawn_of(prepared)
    gives = fit_model(prepared, (bristle("lugre"),), weights_of(base, prepared, drawn[0]), base.fit, evaluations=1)
    weak = Placed(registry()["dwell_time"], 0, {"rise": -2.0, "time": 1.0})
    law = fit_model(prepared, (weak,), weights_of(base, prepared, drawn[0]), base.fit, evaluations=1)
    assert gives.rows is not None
    assert law.rows is not None
    assert np.mean(gives.rows < drawn) > 0.1
    assert np.all(law.rows >= drawn)


def test_rows_count_by_what_the_model_itself_adds_to_them() -> None:
    """Noise of its own at rest is no gap that a law leaves; where it is not known for noise, it is taken for one."""
    prepared, base, stuck = seen()
    floor, draw = floor_of(prepared), np.random.default_rng(0).standard_normal(base.whole.shape)
    plain = noise_power(prepared.noise, floor, len(base.whole))
    rows = drawn_of(prepared) + np.where(stuck[:, None], 24.0 * plain, 0.0)
    gap = 5.0 * floor * np.sin(np.arange(len(draw)) / 15.0)[:, None]
    own = draw * np.where(stuck[:, None], 5.0, 1.0) * np.sqrt(plain)
    without, law = (with_residual(base, residual) for residual in (gap + draw * np.sqrt(plain), own))
    blind, told = (rank(prepared, [without, replace(law, rows=known)], floor, 0) for known in (None, rows))
    assert told.power[1, 0] == pytest.approx(1.0, abs=0.15)
    assert blind.power[1, 0] > 1.5
    assert told.t[1] > blind.t[1]
    assert told.overall[1] > blind.overall[1]


def test_a_gap_shows_where_only_the_sign_of_a_velocity_is_noisy() -> None:
    """Around its reversals a contact that gives passes on little of the noise, which may hide no gap that it closes."""
    prepared, base, _ = seen()
    floor, draw = floor_of(prepared), np.random.default_rng(0).standard_normal(base.whole.shape)
    plain, drawn = noise_power(prepared.noise, floor, len(base.whole)), drawn_of(prepared)
    loud = drawn > 4.0 * np.median(drawn)
    own = np.where(loud, 0.04 * plain, plain)
    gap = np.where(loud, np.sqrt(plain) * np.sin(np.arange(len(draw)) / 15.0)[:, None], 0.0)
    without, law = (with_residual(base, residual) for residual in (gap + draw * np.sqrt(own), draw * np.sqrt(own)))
    blind, told = (rank(prepared, [without, replace(law, rows=rows)], floor, 0) for rows in (None, drawn + own - plain))
    assert told.overall[1] > 5.0 * blind.overall[1]


def test_rows_are_fitted_by_what_the_model_itself_adds_to_them() -> None:
    prepared, base, stuck = seen()
    floor = floor_of(prepared)
    rows = drawn_of(prepared) + np.where(stuck[:, None], 100.0 * floor**2, 0.0)
    sd, before = (weights_of(model, prepared, floor).sd for model in (replace(base, rows=rows), base))
    fitted = stuck[: len(sd)]
    assert np.all(sd[fitted] >= 10.0 * floor)
    assert np.all(before[fitted] < 5.0 * floor)
    assert sd[~fitted] == pytest.approx(before[~fitted], rel=0.2)


def test_a_model_with_a_compliance_has_no_rows_of_its_own() -> None:
    prepared, base, _ = seen()
    weights = weights_of(base, prepared, floor_of(prepared))
    shaft = Placed(registry()["joint_flexibility"], 0, {"stiffness": 1e4, "damping": 5.0})
    model = fit_model(prepared, (shaft,), weights, base.fit, shaft.values, evaluations=1)
    assert model.rows is None
    assert model.noise is not None


def test_of_a_state_that_runs_away_no_noise_is_known(monkeypatch: pytest.MonkeyPatch) -> None:
    prepared, base, _ = seen()
    judged = Residual(SignalPath(prepared.arm, ()), prepared.held, ())
    monkeypatch.setattr(Residual, "__call__", lambda self, p: (np.full_like(base.whole, np.nan), None))
    assert noise_in_rows(judged, base.fit.p, base.whole, prepared.moved) is None


@pytest.mark.parametrize("law", ["lugre", "maxwell_slip"])
def test_a_bristle_is_tried_by_weights_that_know_what_noise_it_takes_up(law: str) -> None:
    """Before it is fitted, too: at rest, what its encoder misses of a stop; in motion little more than without."""
    prepared, base, _ = seen()
    weights = weights_of(base, prepared, floor_of(prepared))
    path = SignalPath(prepared.arm, (bristle(law),))
    p = start_values(path, base.fit, bristle(law).values)
    counted = Bristled(prepared, path, weights).at(p)
    stuck = np.concatenate([run.stuck[run.analysis_index, 0] for run in prepared.fit]).astype(bool)
    missed = STIFFNESS * prepared.fit[0].noise[0]
    assert missed == pytest.approx(STIFFNESS * NOISE, rel=0.3)
    assert np.median(counted.sd[stuck, 0] / np.hypot(missed, weights.sd[stuck, 0])) == pytest.approx(1.0, abs=0.1)
    assert 1.0 <= np.median(counted.sd[~stuck, 0] / weights.sd[~stuck, 0]) < 1.5
    assert np.median(counted.sd[stuck, 0] / weights.sd[stuck, 0]) > 3.0
    plain = SignalPath(prepared.arm, ())
    assert Bristled(prepared, plain, weights).at(values_of(plain.entries)) is weights


def test_beside_a_compliance_a_bristle_is_counted_as_it_is_alone() -> None:
    """It passes on less noise than the sign of a velocity, which is no merit of the compliance: none is put back."""
    prepared, base, stuck = seen()
    floor = floor_of(prepared)
    shaft = Placed(registry()["joint_flexibility"], 0, {"stiffness": 2000.0, "damping": 0.5})
    weights = weights_of(base, prepared, floor)
    soft, both = (
        fit_model(prepared, placed, weights, base.fit, evaluations=1)
        for placed in ((shaft,), (shaft, bristle("lugre")))
    )
    assert soft.noise is not None
    assert soft.rows is None
    assert both.noise is not None
    bent = fit_model(prepared, (bristle("lugre"),), weights, base.fit, evaluations=1)
    against = {name: referred(prepared, model) for name, model in (("sign", base), ("bristle", bent))}
    assert quieter(against["sign"], soft.noise, floor) < 0.9
    assert quieter(against["sign"], both.noise, floor) == 1.0
    assert quieter(against["bristle"], both.noise, floor) < 0.9
    assert both.rows is not None
    assert np.median(both.rows[stuck, 0]) > np.median(drawn_of(prepared)[stuck, 0])


@pytest.mark.parametrize(("effect", "values"), [("payload", {"mass": 12.0}), ("torque_gain", {"gain": 0.4})])
def test_what_makes_more_torque_of_the_same_noise_knows_it(effect: str, values: dict[str, float]) -> None:
    """A mass at the tip, or a drive that gives less for its command; a spring, which does not, has no rows of its own.

    So they are told beside a compliance that is tried from there, which has none.
    """
    prepared, base, stuck = seen()
    weights, drawn = weights_of(base, prepared, floor_of(prepared)), drawn_of(prepared)
    placed = Placed(registry()[effect], 0, values)
    heavy = fit_model(prepared, (placed,), weights, base.fit, values, evaluations=0)
    assert heavy.rows is not None
    assert np.median(heavy.rows[~stuck] / drawn[~stuck]) > 2.0
    assert np.all(heavy.rows >= drawn)
    spring = Placed(registry()["cable_spring"], 0, {"stiffness": 1.0})
    assert fit_model(prepared, (spring,), weights, base.fit, evaluations=1).rows is None
    soft = replace(heavy, rows=None, noise=base.noise)
    known, unknown = (
        rank(prepared, [replace(heavy, rows=rows), soft], floor_of(prepared), 0) for rows in (heavy.rows, None)
    )
    assert known.power[1, 0] < 0.7 * unknown.power[1, 0]


@pytest.mark.long
def test_of_a_joint_without_a_bristle_beside_a_compliance_no_rows_are_known() -> None:
    """The re-tuned model's are counted there; zeros would make a joint without noise of it."""
    arm = nominal_arm()
    prepared = prepare(arm, example_runs()[:3])
    floor = np.full(2, 0.05)
    base = retune(prepared, floor, rounds=1)
    weights = weights_of(base, prepared, floor)
    placed = (bristle("lugre"), Placed(registry()["joint_flexibility"], 1, {"stiffness": 5000.0, "damping": 1.0}))
    model = fit_model(prepared, placed, weights, base.fit, evaluations=1)
    assert model.rows is not None
    assert np.all(np.isfinite(model.rows[:, 0]))
    assert np.all(np.isnan(model.rows[:, 1]))
