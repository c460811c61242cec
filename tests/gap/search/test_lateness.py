"""A drive's own millisecond is re-tuned; what is later than any drive is found as an effect."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.effects.registry import effect_named, registry
from stribeck.gap.diagnose import diagnose
from stribeck.gap.fitted.model import retune
from stribeck.gap.records.prepare import prepare
from stribeck.gap.search.lateness import on_time
from stribeck.model.layout import Placed

from ...effects.bench import nominal_arm
from ...effects.bench import recorded as late_at
from ..conftest import NOMINAL, recorded

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


@pytest.mark.slow
def test_a_model_that_leaves_lateness_out_is_fitted_by_its_own_weights() -> None:
    """By those of the whole gap, presliding left 0.38 N m; what it leaves beside the lateness is a quarter of that."""
    hidden = (("delay", {"time": 0.001}), ("presliding", {"stiffness": 200.0, "damping": 1.0}))
    others = [name for name in registry() if name not in ("presliding", "actuator_lag")]
    found = diagnose(NOMINAL, recorded(*hidden), jobs=1, leave_out=others)
    assert found.named == ("presliding",)
    assert found.stages[2].torque["A"] < 0.2


def test_records_that_are_all_late_leave_no_drive_to_try() -> None:
    """A lateness of its own beside that of the logger would be one too many, at any joint."""
    floor = np.full(2, 0.02)
    prepared = prepare(nominal_arm(), late_at("delay", ("B",), {"time": 0.001}))
    base = retune(prepared, floor)
    assert [place.joint for place in on_time(prepared, base, floor, 0).placed] == [1]
    logger = [Placed(effect_named("time_shift", "all_joints"), 0, {"time": 1e-4})]
    base = retune(prepared, floor, logger)
    assert on_time(prepared, base, floor, 0) is base


def test_a_lateness_that_re_tuning_takes_back_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """A delay of next to nothing would still keep an arm from loops without samples."""
    prepared = prepare(NOMINAL, recorded(("delay", {"time": 0.001})))
    base = retune(prepared, FLOOR)
    taken = on_time(prepared, base, FLOOR, 0)
    back = replace(taken, placed=(*taken.placed[:-1], replace(taken.placed[-1], values={"time": 1e-9})))
    monkeypatch.setattr("stribeck.gap.search.lateness.retune", lambda *given: back)
    assert on_time(prepared, base, FLOOR, 0) is base
