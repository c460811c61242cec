"""Which residual a fit follows, and how wide its secants are."""

from __future__ import annotations

import pytest

from stribeck.effects.registry import registry
from stribeck.gap.fitted.differentiable import SHIFT_STEP, _step, differentiable
from stribeck.gap.records.prepare import Prepared, prepare
from stribeck.identify.residual import Residual
from stribeck.identify.secants import Secants
from stribeck.identify.shifted import Shifted
from stribeck.model.layout import Placed
from stribeck.model.path import SignalPath
from stribeck.model.values import Parameter

from ..conftest import NOMINAL, recorded

LATE = Placed(registry()["time_shift"], 0, {"time": 0.01})
PLAY = Placed(registry()["backlash"], 0, {"gap": 0.01, "stiffness": 3000.0, "damping": 3.0})
DELAY = Placed(registry()["delay"], 0, {"time": 0.01})


@pytest.fixture(scope="module")
def prepared() -> Prepared:
    return prepare(NOMINAL, recorded())


@pytest.mark.parametrize("far", [False, True])
def test_a_late_record_alone_has_a_secant_and_a_late_command_has_not(prepared: Prepared, far: bool) -> None:
    path = SignalPath(prepared.arm, [DELAY, LATE])
    residual = differentiable(path, prepared, prepared.fit, far=far)
    assert isinstance(residual, Shifted)
    assert {path.entries[i].key for i in residual.steps} == {path.entries[i].key for i in path.shifts}
    assert list(residual.steps.values()) == [SHIFT_STEP[far] / prepared.cutoff]
    assert path.entries[path.shifts[0]].owner == 1
    plain = differentiable(SignalPath(prepared.arm, [DELAY]), prepared, prepared.fit, far=far)
    assert type(plain) is Residual


@pytest.mark.parametrize("far", [False, True])
def test_beside_a_play_a_late_record_keeps_its_own_width(prepared: Prepared, far: bool) -> None:
    path = SignalPath(prepared.arm, [PLAY, LATE])
    residual = differentiable(path, prepared, prepared.fit, far=far)
    assert isinstance(residual, Secants)
    assert residual.steps[path.shifts[0]] == SHIFT_STEP[far] / prepared.cutoff
    gap = next(i for i, entry in enumerate(path.entries) if entry.name == "gap")
    assert residual.steps[gap] == path.rough


class Bleeding(type(PLAY.effect)):  # type: ignore[misc]
    """A play with a rate among its parameters."""

    parameters = (*PLAY.effect.parameters, Parameter("rate", "1/s", "a rate", 0.0, 0.0))


def test_a_rate_has_a_secant_of_its_own_size(prepared: Prepared) -> None:
    """Not that of a wave over position, whose unit begins alike."""
    path = SignalPath(prepared.arm, [Placed(Bleeding(), 0, {**PLAY.values, "rate": 5.0})])
    (rate,) = (entry for entry in path.entries if entry.name.endswith("rate"))
    assert _step(path, rate, {rate.key: 5.0}, prepared) == path.rough * 5.0
