"""A shift by up to half a row is told to be what a log of a faster controller's commands has; no other one is."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.effects.registry import registry
from stribeck.gap.answer.as_sampled import told_as_sampled
from stribeck.gap.diagnose import diagnose
from stribeck.gap.result import Cause, Estimate
from stribeck.identify.conditioning import held_command

from ..conftest import NOMINAL, recorded

STEP = 0.01  # s


def shift(milliseconds: float, effect: str = "time_shift", margin: float = 0.4) -> Cause:
    time = Estimate(*(1e-3 * (milliseconds + side * margin) for side in (0.0, -1.0, 1.0)), "s")
    return Cause(effect, 0.9, ("A", "B"), (effect,), {"A": {"time": time}, "B": {"time": time}}, presence=0.9)


@pytest.mark.parametrize("every", [2, 5, 20])
def test_some_commands_of_a_faster_controller_are_late_by_what_is_told(every: int) -> None:
    """As the middle of what lies between them: a row's command is taken for the whole row's."""
    fast = STEP / every
    t = fast * np.arange(40_000)
    slow = t[::every]
    logged = held_command(np.sin(2.0 * np.pi * (slow + 0.5 * fast))[:, None])[:, 0]  # each about the middle of its own
    wave = np.exp(2j * np.pi * slow)
    late = -np.angle((logged @ wave.conj()) * 1j) / (2.0 * np.pi)
    assert late == pytest.approx(0.5 * (STEP - fast), rel=1e-3)
    (said,) = told_as_sampled([shift(-1e3 * late)], ["time_shift"], STEP)
    assert "from row to row" in said


def test_other_shifts_are_not() -> None:
    for milliseconds in (-12.0, -1.5, 4.0):
        assert not told_as_sampled([shift(milliseconds)], ["time_shift"], STEP)
    assert not told_as_sampled([shift(-4.0)], [], STEP)
    assert not told_as_sampled([shift(-4.0, "delay")], ["delay"], STEP)
    assert not told_as_sampled([replace(shift(-4.0), parameters={})], ["time_shift"], STEP)


def test_a_diagnosis_says_so() -> None:
    others = [name for name in registry() if name not in ("time_shift", "cogging")]
    found = diagnose(NOMINAL, recorded(("time_shift", {"time": -1.8e-3})), jobs=1, leave_out=others)  # of 4 ms
    assert found.named == ("time_shift",)
    assert any("from row to row" in note for note in found.notes)
