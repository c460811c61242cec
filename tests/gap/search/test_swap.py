"""Other effects in the place of one that was taken."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stribeck.gap.search.beside import without_each
from stribeck.gap.search.step import last_model
from stribeck.gap.search.swap import swapped

from .test_instead import POOL, TURNED, setting_of, two_steps


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
