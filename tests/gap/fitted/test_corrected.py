"""A fitted model as an arm: every fitted value finds its place in the arm file."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.arm import Arm, EffectEntry, Friction
from stribeck.effects.placing import placed_effects
from stribeck.effects.registry import effect_named
from stribeck.gap.fitted.corrected import arm_of
from stribeck.identify.map_fit import Fit
from stribeck.model.layout import Placed, layout, values_of

from ..conftest import JOINT, TRUE

BACKWARD = Friction(4.1, 1.0, 1.2, 0.05)
SIDED = replace(TRUE, joints=(replace(JOINT, backward=BACKWARD), replace(JOINT, name="B")))


@pytest.mark.parametrize("arm", [TRUE, SIDED], ids=["symmetric", "two-sided"])
def test_values_come_back(arm: Arm) -> None:
    """The layout of the corrected arm holds the fit's values, key by key."""
    placed = [Placed(effect_named("payload"), arm.n - 1, {"mass": 0.4}), Placed(effect_named("delay"), 0)]
    entries = layout(arm, placed)
    p = values_of(entries) * np.linspace(1.1, 1.9, len(entries)) + 0.01
    own = [{e.name: float(v) for e, v in zip(entries, p, strict=True) if e.owner == k} for k in range(2)]
    fit = Fit(entries, p, np.arange(len(p)), np.zeros((1, arm.n)), np.zeros((1, arm.n, len(p))), 0, 0, "ok", ())
    corrected = arm_of(arm, fit, [replace(place, values=v) for place, v in zip(placed, own, strict=True)])
    again = layout(corrected, placed_effects(corrected))
    assert [entry.key for entry in again] == [entry.key for entry in entries]
    assert values_of(again) == pytest.approx(p)
    assert corrected.gravity == arm.gravity
    assert [joint.length for joint in corrected.joints] == [joint.length for joint in arm.joints]


def test_symmetric_friction_stays_symmetric() -> None:
    entries = layout(TRUE, [])
    p = 1.2 * values_of(entries)
    fit = Fit(entries, p, np.arange(len(p)), np.zeros((1, 1)), np.zeros((1, 1, len(p))), 0, 0, "ok", ())
    joint = arm_of(TRUE, fit, []).joints[0]
    assert joint.friction == joint.backward
    assert pytest.approx(1.2 * 4.6) == joint.friction.C0


def test_effects_of_the_arm_file_that_read_the_records_stay() -> None:
    """A delay is fitted and comes with its value; a coarse encoder and a velocity that trails are as the file says."""
    stated = (("encoder_quantisation", "resolution", 2e-3), ("delay", "time", 0.01), ("velocity_filter", "time", 0.02))
    own = tuple(EffectEntry(name, ("A",), {"A": {key: value}}) for name, key, value in stated)
    fitted = Placed(effect_named("delay"), 0, {"time": 0.013})
    entries = layout(TRUE, [fitted])
    p = values_of(entries)
    fit = Fit(entries, p, np.arange(len(p)), np.zeros((1, 1)), np.zeros((1, 1, len(p))), 0, 0, "ok", ())
    effects = arm_of(replace(TRUE, effects=own), fit, [fitted]).effects
    assert {entry.effect: dict(entry.parameters["A"]) for entry in effects} == {
        "encoder_quantisation": {"resolution": 2e-3},
        "delay": {"time": 0.013},
        "velocity_filter": {"time": 0.02},
    }
