"""Other effects in the place of one that was taken, and other effects to begin with."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stribeck.effects.registry import registry
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.search.beside import without_each
from stribeck.gap.search.other_ways import another_way
from stribeck.gap.search.setting import Setting
from stribeck.gap.search.step import last_model
from stribeck.gap.search.swap import swapped

from .test_instead import FLOOR, POOL, TURNED, two_steps


def setting_of(prepared: Prepared, *library: str) -> Setting:
    """A setting in which only some effects are candidates."""
    out = tuple(name for name in registry() if name not in library)
    return Setting(prepared, FLOOR, 0, POOL, out, frozenset(), lambda text: None)


def test_what_a_step_has_not_seen_is_tried_in_the_place_of_what_it_took() -> None:
    """A pendulum's tilt is its encoder's offset once the payload is known; a spring is neither."""
    prepared, steps = two_steps(TURNED, "gravity_tilt", "cable_spring", "payload")
    setting = setting_of(prepared, "gravity_tilt", "encoder_offset", "cable_spring", "payload")
    without = without_each(prepared, steps, POOL)
    found = swapped(setting, steps, without)
    assert [(one.place.key, one.model.placed[-1].effect.name) for one in found] == [
        (("gravity_tilt", 0), "encoder_offset")
    ]
    assert found[0].model.rms() == pytest.approx(last_model(steps).rms(), rel=0.05)
    assert found[0].model.placed[-1].values["offset"] == pytest.approx(0.05, abs=0.01)
    assert swapped(setting, steps[:1], without[:1]) == []  # of one alone, its step has seen them all
    ran_away: Any = SimpleNamespace(whole=np.full((1, 1), np.nan))
    assert swapped(setting, steps, [ran_away, without[1]]) == []


def test_where_much_is_left_the_search_begins_with_another_effect() -> None:
    hidden = [("torque_offset", {"offset": 1.5}), ("delay", {"time": 0.02})]
    prepared, (first, second) = two_steps(hidden, "cable_spring", "torque_offset", "payload")
    setting = setting_of(prepared, "cable_spring", "torque_offset", "delay", "payload")
    base = first.base
    ended = (replace(first, passing=(1, 2)), replace(second, passing=()))
    found = another_way(setting, base, ended)
    assert [step.best.placed[-1].effect.name for step in found if step.taken and step.best] == [
        "torque_offset",
        "delay",
    ]
    assert last_model(found).rms()[0] < 0.3 * last_model(ended).rms()[0]
    assert another_way(setting, base, found) is found  # which leaves little
    refused = (first, replace(second, passing=()))
    assert another_way(setting, base, refused) is refused  # what may not be taken is not begun with
    nothing = (replace(first, passing=()),)
    assert another_way(setting, base, nothing) is nothing
