"""Commands that are not what the arm file is about are told of; a gain, an effect or noise is not."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.effects.registry import registry
from stribeck.gap.answer.commands import commands_beside
from stribeck.gap.diagnose import diagnose

from ..conftest import NOMINAL, recorded


@pytest.mark.parametrize(
    ("factor", "told"), [(-1.0, "signs"), (0.02, "unit"), (1000.0, "unit"), (0.5, None), (1.5, None), (0.0, None)]
)
def test_a_factor_that_no_drive_has(factor: float, told: str | None) -> None:
    rng = np.random.default_rng(0)
    needed = rng.normal(size=(500, 2))
    asked = needed * [1.0, factor] + 0.3 * abs(factor) * rng.normal(size=needed.shape)
    found = commands_beside(asked, needed, ("A", "B"))
    assert len(found) == (told is not None)
    assert all(text.startswith("B: ") and told in text for text in found)


def test_what_is_unlike_is_no_multiple() -> None:
    asked, needed = np.random.default_rng(0).normal(size=(2, 500, 1))
    assert commands_beside(-9.0 * asked, needed, ("A",)) == []


def test_a_wrong_sign_is_told_of_in_a_diagnosis() -> None:
    others = [name for name in registry() if name != "delay"]
    runs = recorded()
    right = diagnose(NOMINAL, runs, jobs=1, leave_out=others)
    wrong = diagnose(NOMINAL, [replace(run, tau=-run.tau) for run in runs], jobs=1, leave_out=others)
    assert not any("check the signs" in text for text in right.warnings)
    assert any("check the signs" in text for text in wrong.warnings)
