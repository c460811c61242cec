"""Whether one joint's rounds die out, and whether they are rounds of one cycle."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.arm import Arm, EffectEntry, Friction
from stribeck.loop.exact.ending import Ending, answers
from stribeck.loop.exact.engine import RoundsEngine
from stribeck.loop.exact.rounds import Rounds
from stribeck.loop.exact.shooting import shoot
from stribeck.loop.exact.turns import CREEP, TINY, dies_out
from stribeck.loop.exact.wish import TURN
from stribeck.loop.watched import watched
from stribeck.simulate import close_loop

from .conftest import one_joint


def rounds(*spread: float) -> np.ndarray:
    """Turns whose rounds span twice these, rad."""
    out = np.zeros(len(spread), dtype=[("low", float), ("high", float)])
    out["low"], out["high"] = -np.array(spread), np.array(spread)
    return out


def test_a_tiny_turn_among_large_ones_is_no_rest():
    assert not dies_out(rounds(0.1, 0.1, 0.1, 0.1, 0.1, 0.09 * TINY))  # where it stops, a sampled joint turns once more
    assert not dies_out(rounds(0.1, 0.05, 0.02, 2.0 * CREEP, 0.1 * CREEP, 0.1 * TINY))


@pytest.mark.parametrize("first", [0.1 * CREEP, 0.5 * CREEP])
def test_small_rounds_that_vanish_are_rest(first):
    assert dies_out(rounds(0.1, 0.01, first, 0.1 * first, 0.01 * first, 0.1 * TINY))
    assert dies_out(rounds(*(first * 0.9**k for k in range(10))))
    assert not dies_out(rounds(*(first * 1.1**k for k in range(10))))


@pytest.mark.parametrize(("carried", "verdict"), [(0.01, "sliding_cycle"), (0.2, "undetermined")])
def test_rounds_about_a_middle_that_swings_are_no_cycle(joint_a, loop_of, carried, verdict):
    """The amplitude is half the peak-to-peak position, which no single round shows then."""
    settled = Rounds(joint_a, loop_of(sample_time=0.0125))
    turns = np.zeros(100, TURN)
    turns["time"] = np.arange(100.0)
    middle = carried * np.sin(0.3 * turns["time"])
    turns["low"], turns["high"], turns["deviation"] = middle - 0.1, middle + 0.1, middle + 0.1
    ending = Ending("roughly", settled.start({}), turns, 99.0)
    assert answers(settled, ending, alike=False)["A"].verdict == "sliding_cycle"
    found = answers(settled, ending)["A"]
    assert found.verdict == verdict
    if verdict == "undetermined":
        assert found.amplitude is None
        assert found.status.startswith("its swings are not alike, ±107 mrad on average, ±300 mrad all together")


@pytest.mark.long
def test_a_motion_of_two_frequencies_is_no_cycle(loop_of):
    """A flexible joint at 11 Hz, carried by a swing of half a hertz that the integral feeds."""
    friction, backward = Friction(5.0, 1.25, 0.2, 0.05), Friction(4.0, 1.0, 1.0, 0.05)
    values = {"mass": 2.0, "com": (0.2, 0.0), "inertia": 0.7, "rotor_inertia": 0.22, "torque_limit": 25.0}
    joint = replace(one_joint(friction).joints[0], friction=friction, backward=backward, **values)
    flexible = {"A": {"stiffness": 800.0, "damping": 0.5}}
    arm = Arm("flexible", (0.0, 0.0), (joint,), effects=(EffectEntry("joint_flexibility", ("A",), flexible),))
    settings = {"kp": 150.0, "ki": 75.0, "delay_samples": 1, "actuator_lag": 0.01}
    loop = loop_of(0.8, "zero", error=0.1, sample_time=0.0125, **settings)
    found, seen = shoot(arm, loop)["A"], watched(close_loop(RoundsEngine(arm), loop), 0)
    assert (found.verdict, found.status.split(",")[0]) == ("undetermined", "its swings are not alike")
    assert seen == "its swings are not alike"
