"""What a step's data cannot tell from what it took."""

from types import SimpleNamespace
from typing import Any

from stribeck.effects.registry import effect_named
from stribeck.gap.experiment.proposal import open_question
from stribeck.gap.search.step import alike
from stribeck.model.layout import Placed


def searched(*later: Placed) -> list[Any]:
    """A step that took a limit of torque where two others did as well, and a step after it."""
    limit, sides, offset = (Placed(effect_named(name), joint) for name, joint in RIVALS)
    rivals = tuple(SimpleNamespace(placed=(place,)) for place in (limit, sides, offset))
    ranking = SimpleNamespace(best=1, twins=lambda: [1, 2, 3], overall=[0.0, 0.99, 0.8, 0.9])
    best = SimpleNamespace(placed=(limit, *later))
    first = SimpleNamespace(taken=True, rivals=rivals, best=rivals[0], ranking=ranking, as_good=())
    alone = SimpleNamespace(best=1, twins=lambda: [1], overall=[0.0, 0.9])
    return [first, SimpleNamespace(taken=True, rivals=(best,), best=best, base=rivals[0], ranking=alone, as_good=())]


RIVALS = (("torque_saturation", 0), ("asymmetric_friction", 1), ("torque_offset", 1))


def test_the_likeliest_comes_first() -> None:
    steps = searched()
    assert alike(steps[0], steps) == [1, 3, 2]


def test_what_is_taken_next_is_no_look_alike_but_a_second_gap() -> None:
    """Two gaps of a size, at two joints: each closes as much as the other."""
    steps = searched(Placed(effect_named("asymmetric_friction"), 1))
    assert alike(steps[0], steps) == [1, 3]
    asked = open_question(steps, {"torque_saturation"})
    assert [model.placed[-1].effect.name for model in asked] == ["torque_saturation", "torque_offset"]


def test_the_same_effect_at_another_joint_may_still_be_meant() -> None:
    steps = searched(Placed(effect_named("asymmetric_friction"), 0))
    assert alike(steps[0], steps) == [1, 3, 2]
