"""What is named must hold in the model that is delivered."""

import pytest

from stribeck.gap.answer.assembly import Assembly
from stribeck.gap.result import Estimate

CLOSES = {"delay": 0.9, "cogging": -0.02, "payload": 0.0}


def test_what_closes_nothing_without_the_others_is_idle(monkeypatch: pytest.MonkeyPatch) -> None:
    assembly = object.__new__(Assembly)
    assembly.models = []
    monkeypatch.setattr(assembly, "_closed_by", lambda effect, chain: Estimate(CLOSES[effect], -1.0, 1.0))
    assert assembly._idle(("delay", "cogging", "payload"), ["a shorter chain"]) == ["cogging", "payload"]  # type: ignore[list-item]
    assert assembly._idle(("delay", "cogging"), assembly.models) == []  # as the search left it
