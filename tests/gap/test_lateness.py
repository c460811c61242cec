"""A drive's own millisecond is re-tuned; what is later than any drive is found as an effect."""

import numpy as np
import pytest

from stribeck.gap.lateness import on_time
from stribeck.gap.model import retune
from stribeck.gap.prepare import prepare

from .conftest import NOMINAL, recorded

FLOOR = np.array([0.02])


@pytest.mark.parametrize(("delay", "taken"), [(0.0, False), (0.001, True), (0.012, False)])
def test_only_what_any_drive_has_is_taken_up(delay: float, taken: bool) -> None:
    runs = recorded(("delay", {"time": delay})) if delay else recorded()
    prepared = prepare(NOMINAL, runs)
    base = retune(prepared, FLOOR)
    model = on_time(prepared, base, FLOOR, 0)
    assert [place.effect.name for place in model.placed] == ["delay"] * taken
    if taken:
        assert model.placed[0].values["time"] == pytest.approx(delay, rel=0.5)
        assert model.rms() < base.rms()
    assert on_time(prepared, base, FLOOR, 0, leave_out=["delay"]) is base
