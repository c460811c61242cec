"""An encoder offset at the last joint, and the centre of mass that no motion tells from it."""

import math
from dataclasses import replace

import numpy as np
import pytest
from tests.effects.bench import nominal_arm, recorded, true_arm

from stribeck.arm import Arm
from stribeck.effects.registry import effect_named
from stribeck.gap.answer.off_the_line import told_off_the_line
from stribeck.gap.records.prepare import prepare
from stribeck.gap.result import Cause, Estimate
from stribeck.gap.search.setting import Asked
from stribeck.gap.search.tuned import retuned
from stribeck.identify.conditioning import Conditioned, condition
from stribeck.identify.residual import Residual
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath
from stribeck.withheld.excitation import programme
from stribeck.withheld.recorder import default_gains, record

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


@pytest.mark.parametrize("held", [False, True])
def test_beside_the_line_of_a_link_that_carries_another_a_centre_of_mass_is_re_tuned(held: bool) -> None:
    """There no effect does just the same: what is left of it else would be named for one."""
    true, sheet = true_arm(), nominal_arm()
    a, b = true.joints
    true = replace(true, joints=(replace(a, com=(a.com[0], 0.005)), b))
    a, b = sheet.joints
    nominal = replace(sheet, joints=(replace(a, com=(a.com[0], 0.0), tolerance={"com_y": 0.0} if held else {}), b))
    motions = programme(sheet, np.random.default_rng(1), ("slow reversals", "multisine"), 4.0)
    gains = default_gains(sheet, 3.0)
    runs = record(true, (), motions, rate=250.0, noise=1e-5, gains=gains, model=sheet, seed=5)
    tuned = retuned(prepare(nominal, runs, runs[1:]), Asked(jobs=1))
    left = tuned.base.rms()[0] / tuned.noise.rms[0]
    assert left > 3.0 if held else left < 1.5
    if not held:
        beside = dict(zip((entry.key for entry in tuned.base.fit.entries), tuned.base.fit.p, strict=True))["A.com_y"]
        assert beside == pytest.approx(0.005, abs=0.001)
