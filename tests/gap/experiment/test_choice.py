"""Which of the promising experiments is proposed: by what each tells whichever model is true, and what it asks for."""

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stribeck.gap.answer import assembly
from stribeck.gap.answer.assembly import Assembly
from stribeck.gap.experiment import proposal
from stribeck.gap.experiment.changes import Change
from stribeck.gap.experiment.separation import AS_IT_IS
from stribeck.gap.result import Cause

TOLD, OPEN = 30.0, 0.0  # t values
CHANGE = Change("turn it round")


def proposed(promised: Sequence[tuple[Sequence[float], Change]], monkeypatch: pytest.MonkeyPatch) -> int:
    """Return which of the experiments is proposed, told how far the next one is from each model (t), and the change."""
    offers = [SimpleNamespace(nearest=np.array(far), change=change, k=k) for k, (far, change) in enumerate(promised)]

    class Plan:
        def __init__(self, *given: Any) -> None: ...

        def choices(self, *, as_it_is: bool) -> Sequence[Any]:
            return [offer for offer in offers if not as_it_is or offer.change is AS_IT_IS]

    monkeypatch.setattr(proposal, "Plan", Plan)
    monkeypatch.setattr(proposal, "_experiment", lambda plan, choice: choice)
    found: Any = proposal.next_experiment(None, (), np.ones(1))  # type: ignore[arg-type]
    return int(found.k)


def test_one_that_stands_out_is_not_the_whole_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    """The likeliest of four may come out far from the others, and these look alike still."""
    one, half = [TOLD, OPEN, OPEN, OPEN], [TOLD, TOLD, OPEN, OPEN]
    assert proposed([(one, AS_IT_IS), (half, AS_IT_IS)], monkeypatch) == 1
    assert proposed([([TOLD] * 4, AS_IT_IS), (half, AS_IT_IS)], monkeypatch) == 0


def test_a_change_is_laborious(monkeypatch: pytest.MonkeyPatch) -> None:
    """A sixth more is worth a wider motion, and no change; of two changes the better one is made."""
    third, half = [TOLD, TOLD, OPEN, OPEN, OPEN, OPEN], [TOLD, TOLD, TOLD, OPEN, OPEN, OPEN]
    most = [TOLD, TOLD, TOLD, TOLD, OPEN, OPEN]
    assert proposed([(third, AS_IT_IS), (half, AS_IT_IS)], monkeypatch) == 1
    assert proposed([(third, AS_IT_IS), (half, CHANGE)], monkeypatch) == 0
    assert proposed([([OPEN] * 6, AS_IT_IS), (half, CHANGE), (most, CHANGE)], monkeypatch) == 2


@pytest.mark.parametrize("unexplained", [True, False])
def test_the_arm_is_changed_only_to_tell_a_class_apart(unexplained: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[bool] = []
    monkeypatch.setattr(assembly, "open_question", lambda steps, unexplained: ("a model",))
    monkeypatch.setattr(assembly, "next_experiment", lambda *given, as_it_is: asked.append(as_it_is))
    told: Any = SimpleNamespace(steps=(), prepared=None, floor=np.ones(1))
    either = [Cause("delay", 0.9, ("A",), ("delay", "time_shift"), presence=0.9)]
    Assembly._experiment(told, either, unexplained=unexplained)
    assert asked == [unexplained]
