"""The noise floor of what is delivered: that of the arm, whatever was missing in the model before."""

import numpy as np
import pytest

from stribeck.effects.registry import effect_named, registry
from stribeck.gap.answer import closing, stages
from stribeck.gap.answer.noise import heard_through
from stribeck.gap.diagnose import diagnose
from stribeck.gap.fitted.model import Model, fit_model, weights_of
from stribeck.gap.records.prepare import prepare
from stribeck.gap.result import Diagnosis, Estimate
from stribeck.gap.search.setting import Asked
from stribeck.gap.search.tuned import Retuned, retuned
from stribeck.model.layout import Placed

from ..conftest import NOMINAL, recorded

HIDDEN = ("cogging", {"amplitude": 6.0, "harmonic": 12.0, "phase": 0.3})
START = {"sine": 4.0, "cosine": 4.0, "harmonic": 12.0}


def tuned(*effects: tuple[str, dict[str, float]]) -> Retuned:
    return retuned(prepare(NOMINAL, recorded(*effects)), Asked())


def with_cogging(found: Retuned) -> Model:
    prepared, floor, base = found.prepared, found.noise.rms, found.base
    placed = (*base.placed, Placed(effect_named("cogging"), 0, START))
    model = fit_model(prepared, placed, weights_of(base, prepared, floor), base.fit, START)
    for _ in range(2):  # the first weights are those of a large gap
        model = fit_model(prepared, model.placed, weights_of(model, prepared, floor), model.fit)
    return model


def test_a_gap_does_not_count_as_noise() -> None:
    """Filters round off what is sharp in it; beside what closes it they leave what they leave on an arm without."""
    without, found = tuned(), tuned(HIDDEN)
    searched, chain = found.noise.rms, [found.base, with_cogging(found)]
    assert searched > 2.0 * without.noise.rms
    heard = heard_through(found.prepared, chain, searched, 0)
    assert without.noise.rms < heard.floor < 0.6 * searched
    assert np.sqrt(np.mean(heard.rows**2, axis=0)) == pytest.approx(heard.floor)
    assert heard.prepared.noise is not None
    assert heard.prepared.noise.rms <= heard.floor
    assert heard_through(found.prepared, chain, 0.5 * heard.floor, 0).floor <= 0.5 * heard.floor  # no more than that


def test_without_another_model_it_is_the_same() -> None:
    found = tuned()
    assert heard_through(found.prepared, [found.base], found.noise.rms, 0).floor == pytest.approx(found.noise.rms)


def answered(*candidates: str) -> Diagnosis:
    """What is said of the recordings with cogging, where only these effects are candidates."""
    others = [name for name in registry() if name not in candidates]
    return diagnose(NOMINAL, recorded(HIDDEN), jobs=1, leave_out=others)


def test_an_answer_has_the_floor_of_what_it_delivers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stages, "WORSE", 0.0)
    found = answered("cogging")
    assert found.named == ("cogging",)
    assert found.stages[-1].torque["A"] < 0.6 * tuned(HIDDEN).noise.rms[0]
    assert found.closed is not None
    assert not any("re-tuned values leave" in warning for warning in found.warnings)


def test_what_is_closed_is_told_by_the_stages_beside_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """As contract and report have the formula: with the noise put back that a model takes in, here half as much."""
    monkeypatch.setattr(closing, "put_back", lambda prepared, rows, noise, floor: 1.5 * rows)
    found = answered("cogging")
    assert found.closed is not None
    retuned, corrected, floor = (np.array([*stage.torque.values()]) for stage in found.stages[1:])
    over = [float(np.sum(rms**2 / floor**2 - 1.0)) for rms in (retuned, corrected)]
    assert found.closed.value == pytest.approx(1.0 - max(over[1], 0.0) / over[0], abs=1e-6)
    assert over[1] > 0.1


def test_where_retuning_leaves_no_more_than_noise_nothing_closes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(closing, "closable", lambda residual, floor: -0.1)
    found = answered("cogging")
    assert found.named == ("cogging",)
    assert found.closed is None
    (closes,) = [cause.closes for cause in found.causes if cause.effect == "cogging"]
    assert closes == Estimate(0.0, 0.0, 0.0)


def test_retuning_that_helps_nobody_is_told_of_where_nothing_is_explained(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stages, "WORSE", 0.0)
    found = answered()
    assert found.verdict == "unexplained"
    assert any(warning.startswith("A: re-tuned values leave") for warning in found.warnings)
    assert found.stages[-1].torque["A"] > 0.9 * tuned(HIDDEN).noise.rms[0]  # no other model is delivered
