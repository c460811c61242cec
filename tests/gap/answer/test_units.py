"""A straight axis has its own units wherever a diagnosis says one."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.arm import Arm, EffectEntry, unit_at
from stribeck.effects.placing import placed_effects
from stribeck.effects.registry import effect_named
from stribeck.errors import InputError
from stribeck.gap.fitted.model import retune
from stribeck.gap.records.observed import observe
from stribeck.gap.records.prepare import prepare
from stribeck.gap.search.ordinary import told_ordinary
from stribeck.model.layout import Placed

from ..conftest import NOMINAL, recorded

STRAIGHT = replace(NOMINAL, joints=(replace(NOMINAL.joints[0], kind="prismatic"),))
OFFSET = {"offset": 0.05}


def test_every_unit_of_a_rotation_has_its_own() -> None:
    pairs = {"N m s/rad": "N s/m", "kg m^2": "kg", "1/rad": "1/m", "N m": "N", "Hz": "Hz", "s": "s"}
    assert {text: unit_at(text, "prismatic") for text in pairs} == pairs
    assert all(unit_at(text, "revolute") == text for text in pairs)


@pytest.mark.parametrize(("arm", "unit"), [(NOMINAL, "N m"), (STRAIGHT, "N")])
def test_what_re_tuning_took_in_is_told_in_them(arm: Arm, unit: str) -> None:
    base = retune(prepare(NOMINAL, recorded()), np.array([0.02]), [Placed(effect_named("torque_offset"), 0, OFFSET)])
    (note,) = told_ordinary(base, (), arm)
    assert f" {unit})" in note


@pytest.mark.parametrize(("arm", "unit"), [(NOMINAL, "rad"), (STRAIGHT, "m")])
def test_what_the_records_show_is_given_in_them(arm: Arm, unit: str) -> None:
    runs = recorded(("encoder_quantisation", {"resolution": 0.002}))
    (cause,) = observe(arm, runs, prepare(arm, runs).scales).causes
    assert cause.parameters["A"]["resolution"].unit == unit


@pytest.mark.parametrize(("arm", "unit"), [(NOMINAL, "N m/rad"), (STRAIGHT, "N/m")])
def test_a_value_out_of_bounds_is_told_in_them(arm: Arm, unit: str) -> None:
    stiff = EffectEntry("joint_flexibility", ("A",), {"A": {"stiffness": -1.0}})
    with pytest.raises(InputError, match=f"{unit}$"):
        placed_effects(replace(arm, effects=(stiff,)))
