"""What is named must hold in the model that is delivered."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stribeck.effects.registry import effect_named
from stribeck.gap.answer.assembly import Assembly, gained
from stribeck.gap.result import Estimate
from stribeck.model.layout import Placed

CLOSES = {"delay": 0.9, "cogging": -0.02, "payload": 0.02, "torque_gain": 0.02}
LEFT = ((1.0, 1.0), (0.3, 1.0), (0.3, 1.1), (0.299, 1.09), (0.299, 1.0))  # N m rms, after one effect more each


def delivered() -> list[Any]:
    """The re-tuned model of two joints, and one more for each effect."""
    names = (None, *CLOSES)
    placed = [(Placed(effect_named(name), 0),) if name else () for name in names]
    return [SimpleNamespace(placed=p, held=np.full((9, 2), 1.0) * left) for p, left in zip(placed, LEFT, strict=True)]


def test_what_hardly_closes_anything_without_the_others_is_idle(monkeypatch: pytest.MonkeyPatch) -> None:
    """A payload that takes two per cent off, and a gain that takes sixteen, off one joint of two."""
    assembly, chain = object.__new__(Assembly), delivered()
    assembly.models = []
    monkeypatch.setattr(assembly, "_closed_by", lambda effect, chain: Estimate(CLOSES[effect], -1.0, 1.0))
    assert assembly._idle(tuple(CLOSES), chain) == ["cogging", "payload"]
    assert assembly._idle(tuple(CLOSES), assembly.models) == []  # as the search left it


def test_a_gain_counts_at_the_joint_that_gains_most() -> None:
    chain = delivered()
    assert gained("delay", chain) == pytest.approx(1.0 - 0.3**2)
    assert gained("torque_gain", chain) == pytest.approx(1.0 - (1.0 / 1.09) ** 2)
    assert gained("backlash", chain) == -np.inf
