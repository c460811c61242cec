"""Other effects to begin with, where those that were taken leave much."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from stribeck.effects.registry import effect_named
from stribeck.gap.search import other_ways as module
from stribeck.gap.search.other_ways import another_way, passed_over
from stribeck.gap.search.step import alike, last_model
from stribeck.model.layout import Placed

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


def test_no_compliance_is_second_and_nothing_is_begun_where_little_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    hidden = [("torque_offset", {"offset": 1.5}), ("delay", {"time": 0.02})]
    prepared, (first, second) = two_steps(hidden, "torque_offset", "cable_spring", "delay")
    left_out: list[tuple[str, ...]] = []

    def forward(setting: Any, base: object, known: object, before: Any, **_: object) -> Any:
        left_out.append(setting.leave_out)
        return before

    monkeypatch.setattr(module, "forward", forward)
    setting = setting_of(prepared, "torque_offset", "delay", "joint_flexibility", "backlash")
    first = replace(first, passing=(1, 2))
    assert another_way(setting, first.base, (first, second))[1] is second
    assert left_out == []
    ended = (first, replace(second, passing=()))
    assert another_way(setting, first.base, ended) is ended
    assert [{"joint_flexibility", "backlash", "base_flexibility"} <= set(names) for names in left_out] == [True]


def test_what_came_after_a_needless_effect_is_taken_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where its step has seen that: a search that starts anew would stand before the same choice."""
    prepared, (first, second) = two_steps([("torque_offset", {"offset": 1.5})], "cogging", "torque_offset", "delay")
    after = replace(second.rivals[0], placed=(*second.base.placed, first.rivals[1].placed[-1]))
    steps = first, replace(second, rivals=(after,))
    setting = replace(setting_of(prepared, "torque_offset", "delay"), barred=frozenset({("cogging", 0)}))
    assert last_model(steps).placed[-1].key == ("torque_offset", 0)
    found = passed_over(setting, first.base, steps, ("cogging", 0))
    assert [step.best.placed[-1].key for step in found if step.taken and step.best] == [("torque_offset", 0)]
    assert [found[0].rivals[k - 1].placed[-1].key for k in alike(found[0], found)] == [("torque_offset", 0)]
    assert found[0].ranking.overall.shape == (2,)
    bound = replace(first.rivals[1], placed=(Placed(effect_named("torque_offset"), 0, {"offset": 1e9}),))
    strained = (replace(first, rivals=(first.rivals[0], bound)), steps[1])
    monkeypatch.setattr(module, "holds", lambda place, scale: place.values["offset"] < 1e6)
    assert passed_over(setting, first.base, strained, ("cogging", 0)) is strained  # nor what rests on a bound
    monkeypatch.undo()
    assert passed_over(setting, first.base, (first, second), ("cogging", 0)) == (first, second)  # a delay it never saw
    blind = replace(first.ranking, overall=0.0 * first.ranking.overall)  # nor what showed nothing there
    hidden = (replace(first, ranking=blind), steps[1])
    assert passed_over(setting, first.base, hidden, ("cogging", 0)) is hidden
