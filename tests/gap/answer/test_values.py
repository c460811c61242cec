"""What re-tuning made of the arm file's values, its effects' among them."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.arm import Arm, EffectEntry
from stribeck.effects.placing import placed_effects
from stribeck.gap.answer.values import tuned_of
from stribeck.gap.fitted.model import retune
from stribeck.gap.records.prepare import prepare
from stribeck.gap.records.unsaid import told_of
from stribeck.gap.result import Tuned

from ..conftest import NOMINAL, recorded

LATE = ("delay", {"time": 0.02})
FLOOR = np.array([0.02])


def retuned(arm: Arm) -> dict[str, Tuned]:
    prepared = prepare(arm, recorded(LATE))
    base = retune(prepared, FLOOR, placed_effects(arm))
    return {value.key: value for value in tuned_of(base, prepared, FLOOR)}


@pytest.mark.parametrize(("stated", "moved"), [(0.018, False), (0.006, True), (0.0, True)])
def test_a_value_of_an_effect_that_has_left_its_nominal_one_far_is_told_of(stated: float, moved: bool) -> None:
    """It has no tolerance that re-tuning would stay in, and is found anew however wrong the file is."""
    own = EffectEntry("delay", ("A",), {"A": {"time": stated}})
    values = retuned(replace(NOMINAL, effects=(own,)))
    time = values["delay[A].time"]
    assert (time.nominal, time.unit, time.tolerance, time.moved) == (stated, "s", np.inf, moved)
    assert time.tuned.value == pytest.approx(0.02, rel=0.05)
    assert time.tuned.low < 0.02 < time.tuned.high
    told = [text for text in told_of(tuple(values.values())) if text.startswith("delay[A].time: ")]
    assert len(told) == moved
    assert all(f"{stated:.3g} in the arm file, {time.tuned.value:.3g} s by the recordings" in text for text in told)


def test_an_arm_without_effects_has_its_own_values_alone() -> None:
    assert all(key.startswith("A.") for key in retuned(NOMINAL))


def test_a_wave_that_keeps_its_size_has_not_moved() -> None:
    """Its cosine is zero in the file: what it comes to is measured by the amplitude of both."""
    wave = EffectEntry("cogging", ("A",), {"A": {"sine": 2.0, "cosine": 0.0, "harmonic": 6.0}})
    hidden = ("cogging", {"amplitude": 2.0, "harmonic": 6.0, "phase": 0.1})
    arm = replace(NOMINAL, effects=(wave,))
    prepared = prepare(arm, recorded(hidden))
    values = tuned_of(retune(prepared, FLOOR, placed_effects(arm)), prepared, FLOOR)
    assert not any(value.moved for value in values)
    assert "cogging[A].cosine" in {value.key for value in values}
