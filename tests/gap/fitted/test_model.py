"""What a fitted model is, whatever its law."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stribeck.arm.values import EffectEntry
from stribeck.effects.placing import placed_effects
from stribeck.gap.fitted.model import Model, finite, retune
from stribeck.gap.records.prepare import prepare

from ..conftest import NOMINAL, recorded


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -1e200])
@pytest.mark.parametrize("where", ["fitted", "held"])
def test_a_model_that_runs_away_on_any_run_is_not_finite(wrong: float, where: str) -> None:
    """A stand that is shaken off its start may come back to numbers on the runs that are held out."""
    rows = {"fitted": np.zeros((4, 2)), "held": np.zeros((3, 2))}
    fit: Any = SimpleNamespace(residual=rows["fitted"])
    assert finite(Model((), fit, rows["held"]))
    rows[where][1, 1] = wrong
    assert not finite(Model((), fit, rows["held"]))


@pytest.mark.parametrize("stated", [(0.4, 0.2), (0.1, 0.0)])
def test_a_stated_wave_of_another_size_keeps_its_pitch(stated: tuple[float, float]) -> None:
    """Steps that need not descend leapt to 11.5 1/rad and left 0.5 N m."""
    wave = dict(zip(("sine", "cosine"), stated, strict=True)) | {"harmonic": 8.0}
    arm = replace(NOMINAL, effects=(EffectEntry("cogging", ("A",), {"A": wave}, "one_wave"),))
    runs = recorded(("cogging", {"amplitude": 0.8, "harmonic": 8.0, "phase": 0.0}))
    found = retune(prepare(arm, runs), np.array([0.02]), placed_effects(arm))
    assert found.placed[0].values == pytest.approx({"sine": 0.8, "cosine": 0.0, "harmonic": 8.0}, abs=0.01)
    assert found.rms()[0] < 0.05
