"""The stages of the gap, and what is said where re-tuning helps nobody."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stribeck.effects.registry import effect_named
from stribeck.gap.answer.motion import ASTRAY, Motions, told_strayed
from stribeck.gap.answer.stages import WORSE, missed, told_missed, told_worse
from stribeck.gap.result import Stage
from stribeck.model.layout import Placed

from ..conftest import JOINT, TRUE

ARM = replace(TRUE, joints=(JOINT, replace(JOINT, name="B")))


def stages(given: float, tuned: float) -> list[Stage]:
    return [
        Stage("as_given", {"A": 0.3, "B": given}, {}),
        Stage("retuned", {"A": 0.1, "B": tuned}, {}),
        Stage("noise_floor", {"A": 0.05, "B": 0.05}, {}),
    ]


def test_retuning_that_makes_it_worse_is_told_of() -> None:
    (said,) = told_worse(stages(0.2, 0.6), ARM)
    assert said.startswith("B: re-tuned values leave 0.6 N m rms on what was held out, the nominal ones 0.2")
    assert told_worse(stages(0.2, 0.99 * WORSE * 0.2), ARM) == []
    assert told_worse(stages(0.0, 0.0), ARM) == []
    assert len(told_worse(stages(0.0, 0.6), ARM)) == 1


def test_a_model_that_leaves_most_of_the_torque_has_not_followed_it() -> None:
    """As of an arm file with a slipped decimal: from 80 N m to 4 of 5 is much, and no explanation."""
    held = [SimpleNamespace(command=np.tile([torque, 0.0], (50, 1))) for torque in (4.0, 6.0)]
    prepared: Any = SimpleNamespace(arm=ARM, held=held)
    floor = np.array([0.1, 0.1])
    (row,) = missed(prepared, np.full((20, 2), 4.2), floor)  # the second joint has no drive
    assert row == ("A", pytest.approx(4.2), pytest.approx(np.sqrt(26.0)))
    assert told_missed([row], ARM)[0].startswith("A: even corrected, the model leaves 4.2 of 5.1 N m rms")
    assert missed(prepared, np.full((20, 2), 2.4), floor) == []
    assert missed(prepared, np.full((20, 2), 4.2), np.array([3.5, 3.5])) == []  # noise that none can follow


@pytest.mark.parametrize(
    ("moved", "strayed"),
    [
        ({"A": 0.01, "B": 0.02 * ASTRAY}, {}),
        ({"A": 0.0, "B": 0.0225 * ASTRAY}, {"delay": pytest.approx(ASTRAY * 0.0225 / np.hypot(0.01, 0.02))}),
        ({}, {}),  # nothing could be simulated: that says nothing
    ],
)
def test_an_effect_goes_astray_whose_motion_is_another_one(
    monkeypatch: pytest.MonkeyPatch, moved: dict[str, float], strayed: dict[str, float]
) -> None:
    """Whatever it takes of the torque: by how much is counted over all joints, against the model before it."""
    names, motions = (None, "cogging", "delay"), Motions(SimpleNamespace())  # type: ignore[arg-type]
    chain: list[Any] = [SimpleNamespace(placed=(Placed(effect_named(name), 0),) if name else ()) for name in names]
    told = ({"A": 0.3, "B": 0.1}, {"A": 0.01, "B": 0.02}, moved)
    known = {id(model): motion for model, motion in zip(chain, told, strict=True)}
    monkeypatch.setattr(motions, "of", lambda model: (known[id(model)], ""))
    assert motions.strayed(chain) == strayed


def test_it_is_said_how_far_it_goes_astray() -> None:
    (said,) = told_strayed({"backlash": 28.02})
    assert said.startswith("backlash: simulated forward, the arm with it goes 28 times as far astray as without")
