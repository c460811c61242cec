"""The noise floor of what is delivered: that of the arm, whatever was missing in the model before."""

import numpy as np
import pytest

from stribeck.effects.registry import effect_named
from stribeck.gap.answer.noise import heard_through
from stribeck.gap.diagnose import Retuned, retuned
from stribeck.gap.fitted.model import Model, fit_model, weights_of
from stribeck.gap.records.prepare import prepare
from stribeck.model.layout import Placed

from ..conftest import NOMINAL, recorded

HIDDEN = ("cogging", {"amplitude": 6.0, "harmonic": 12.0, "phase": 0.3})
START = {"sine": 4.0, "cosine": 4.0, "harmonic": 12.0}


def tuned(*effects: tuple[str, dict[str, float]]) -> Retuned:
    return retuned(prepare(NOMINAL, recorded(*effects)), seed=0, leave_out=(), progress=lambda text: None)


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
