"""An encoder offset at the last joint, and the centre of mass that no motion tells from it."""

import math
from dataclasses import replace

import numpy as np
import pytest
from tests.effects.bench import recorded, true_arm

from stribeck.arm import Arm
from stribeck.effects.registry import effect_named
from stribeck.gap.answer.off_the_line import told_off_the_line
from stribeck.gap.result import Cause, Estimate
from stribeck.identify.conditioning import Conditioned, condition
from stribeck.identify.residual import Residual
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath

OFFSET = 0.03  # rad


def drawn(beside: float = 0.0) -> Arm:
    """The arm with the last centre of mass so far from its joint as before, ``beside`` the line, m."""
    arm = true_arm()
    far = math.hypot(*arm.joints[-1].com)
    com = (math.sqrt(far**2 - beside**2), beside)
    return replace(arm, joints=(arm.joints[0], replace(arm.joints[-1], com=com, tolerance={})))


def offset(value: float, joint: str = "B") -> Cause:
    """A named encoder offset."""
    found = {joint: {"offset": Estimate(value, value, value, "rad")}}
    return Cause("encoder_offset", 0.9, (joint,), ("encoder_offset",), found, presence=0.9)


def residual(arm: Arm, placed: list[Placed], runs: list[Conditioned]) -> np.ndarray:
    """What a model leaves of recordings, N m."""
    path = SignalPath(arm, placed)
    return Residual(path, runs, ())(values_of(path.entries))[0]


def test_the_centre_of_mass_that_is_told_does_what_the_offset_does() -> None:
    arm = drawn()
    runs = [condition(arm, run, 20.0) for run in recorded()]
    turned = residual(arm, [Placed(effect_named("encoder_offset"), 1, {"offset": OFFSET})], runs)
    (note,) = told_off_the_line(arm, [offset(OFFSET)], ["encoder_offset"])
    told = float(note.partition("centre of mass ")[2].partition(" mm")[0]) * 1e-3
    assert told == pytest.approx(-OFFSET * arm.joints[-1].com[0], rel=0.03)
    beside = residual(drawn(-arm.joints[-1].com[0] * math.sin(OFFSET)), [], runs)
    assert np.abs(turned - residual(arm, [], runs)).max() > 0.1
    assert np.abs(turned - beside).max() < 1e-3


@pytest.mark.parametrize(
    ("arm", "cause", "named"),
    [
        (drawn(), offset(OFFSET, "A"), ["encoder_offset"]),
        (drawn(), offset(OFFSET), []),
        (drawn(0.01), offset(OFFSET), ["encoder_offset"]),
        (replace(drawn(), joints=(drawn().joints[0], replace(drawn().joints[1], tolerance={"com_y": 0.0}))),
         offset(OFFSET), ["encoder_offset"]),
    ],
    ids=["another joint", "not named", "the file has it", "the file knows it"],
)  # fmt: skip
def test_silent(arm: Arm, cause: Cause, named: list[str]) -> None:
    assert told_off_the_line(arm, [cause], named) == []
