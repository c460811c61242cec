"""Other effects to begin with, where those that were taken leave much."""

from __future__ import annotations

from dataclasses import replace

from stribeck.gap.search.other_ways import another_way
from stribeck.gap.search.step import last_model

from .test_instead import setting_of, two_steps


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
