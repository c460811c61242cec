"""What a fitted model is, whatever its law."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stribeck.arm import Arm, Friction, Joint
from stribeck.arm.values import EffectEntry
from stribeck.effects.placing import placed_effects
from stribeck.gap.fitted.model import Model, finite, retune
from stribeck.gap.records.prepare import prepare
from stribeck.run import Run

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


def test_a_weight_that_is_far_off_is_re_tuned_in_full() -> None:
    """What its torque leaves is one number: in three rounds its prior held it back, and 0.3 N passed for an offset."""
    friction = Friction(16.0, 5.5, 17.0, 0.022)
    axis = Joint("A", "prismatic", 0.0, 3.9, (0.0, 0.0), 0.0, 1.2, friction, friction, 250.0, 2e-6)
    lift = Arm("lift", (-9.81, 0.0), (axis,), sample_time=0.002)
    t = 0.002 * np.arange(3000)
    rng = np.random.default_rng(0)
    runs = []
    for k in range(3):
        q, v, a = (
            sum(
                0.1 / f * np.real((2j * np.pi * f) ** d * np.exp(1j * (2 * np.pi * f * t + k))) for f in (0.3, 0.8, 1.3)
            )
            for d in range(3)
        )
        level = friction.C0 + friction.C1 * np.exp(-np.abs(v) / friction.alpha)
        torque = 3.9 * (a + 9.81) + 1.2 * a + np.sign(v) * level + friction.C2 * v + 0.3 * rng.standard_normal(len(t))
        runs.append(Run(f"run_{k}", t, np.asarray(q)[:, None], np.asarray(torque)[:, None]))
    nominal = replace(lift, joints=(replace(axis, mass=3.2),))
    found = retune(prepare(nominal, runs), np.array([0.1]))
    assert abs(np.mean(found.whole)) < 0.01
    assert found.fit.value("A.mass") == pytest.approx(3.9, rel=0.01)
