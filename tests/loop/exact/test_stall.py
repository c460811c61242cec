"""Joints that the drive cannot move, however much is asked of it."""

import math
from dataclasses import replace

import pytest

from stribeck.arm import EffectEntry
from stribeck.loop.exact import ending
from stribeck.loop.exact.rounds import Rounds
from stribeck.loop.exact.settle import settle, settle_from
from stribeck.loop.exact.shooting import ending_of, shoot
from stribeck.loop.exact.starts import starts
from stribeck.loop.watched import watched
from stribeck.simulate import Compensation, JointLoop, Loop, Reference, simulate_loop

from .conftest import COULOMB, A, one_joint, two_links

WEAK = 0.8 * (A.C0 + A.C1)  # N m


def weak(arm):
    """Return an arm whose first drive does not reach its joint's break-away torque."""
    first, *others = arm.joints
    return replace(arm, joints=(replace(first, torque_limit=WEAK), *others))


@pytest.mark.parametrize("sample_time", [0.0, 0.005])
def test_a_drive_that_is_too_weak_for_its_ramp_is_named(loop_of, sample_time):
    loop = loop_of(sample_time=sample_time, velocity=0.05)
    for found in (settle(weak(one_joint(A)), loop)["A"], shoot(weak(one_joint(A)), loop)["A"]):
        assert (found.verdict, found.steady_error) == ("undetermined", None)
        assert found.status == "the drive cannot move it: it gives 5 N m and no more"
    strong = settle(one_joint(A), loop)["A"]
    assert strong.verdict == "rest"


@pytest.mark.parametrize("sample_time", [0.0, 0.005])
def test_an_integral_against_a_saturated_drive_never_ends(loop_of, sample_time):
    limit = EffectEntry("torque_saturation", ("A",), {"A": {"limit": WEAK}}, "constant")
    found = settle(replace(one_joint(A), effects=(limit,)), loop_of(sample_time=sample_time, ki=20.0))["A"]
    assert (found.verdict, found.status) == ("undetermined", "the drive cannot move it: it gives 5 N m and no more")


@pytest.mark.parametrize("sample_time", [0.0, 0.005])
def test_a_joint_beside_one_that_stalls_has_its_own_answer(sample_time):
    ramp, step = Reference("ramp", velocity=0.05), Reference("regulate", initial_error=0.3)
    found = settle(weak(two_links()), Loop(sample_time, 20.0, (JointLoop("A", 60.0, ramp), JointLoop("B", 30.0, step))))
    assert found["A"].status.startswith("the drive cannot move it")
    assert found["B"].verdict == "rest"
    assert found["B"].steady_error is not None


@pytest.mark.long
@pytest.mark.parametrize("answer", [settle, shoot])
def test_a_joint_that_stalls_ends_no_search_for_the_cycle_of_another(answer):
    """B hunts as it does with A clamped, whichever way A is left behind."""
    hunts = JointLoop("B", 30.0, Reference("regulate", initial_error=0.3), ki=60.0)
    stalls = JointLoop("A", 60.0, Reference("ramp", velocity=0.05))
    limit = EffectEntry("torque_saturation", ("A",), {"A": {"limit": WEAK}}, "constant")
    alone = answer(two_links(), Loop(0.0, 20.0, (hunts,)))["B"]
    assert alone.verdict == "hunting"
    for arm, entry in (
        (weak(two_links()), stalls),
        (replace(two_links(), effects=(limit,)), replace(stalls, reference=hunts.reference, ki=20.0)),
    ):
        found = answer(arm, Loop(0.0, 20.0, (entry, hunts)))
        assert found["A"].status == "the drive cannot move it: it gives 5 N m and no more"
        assert set(found["B"].basin.values()) == {"hunting"}
        assert (found["B"].amplitude, found["B"].period) == pytest.approx((alone.amplitude, alone.period), rel=1e-3)
        assert found["B"].multipliers == pytest.approx(alone.multipliers, abs=1e-3)


def test_a_joint_that_stalls_does_not_keep_another_from_breaking_away():
    """B winds up for 50 s before it first moves."""
    entries = (
        JointLoop("A", 60.0, Reference("ramp", velocity=0.05)),
        JointLoop("B", 30.0, Reference("regulate"), ki=30.0),
    )
    rounds = Rounds(weak(two_links()), Loop(0.02, 20.0, entries))
    found = ending.answers(rounds, settle_from(rounds, starts(rounds)["small"]))
    assert (found["A"].left, found["B"].verdict) == (True, "hunting")


def test_a_joint_that_rests_ends_no_search_for_the_cycle_of_another():
    step = Reference("regulate", initial_error=0.05)  # by which A's drive does not break it away
    hunts = JointLoop("B", 30.0, step, ki=60.0)
    found = shoot(two_links(), Loop(0.0, 20.0, (JointLoop("A", 60.0, step), hunts)))
    assert (found["A"].verdict, found["A"].steady_error) == ("rest", pytest.approx(0.05))
    assert (found["B"].verdict, found["B"].stable) == ("hunting", True)


@pytest.mark.parametrize("answer", [settle, shoot])
def test_a_joint_that_cannot_be_followed_is_not_said_to_stall(loop_of, answer):
    """The law's sign at rest is zero: continuous, it would let go and stop without end."""
    law = Compensation("adaptive", 1.18, leakage=0.1)
    loop = loop_of(kp=60.0, ki=20.0, error=0.27)
    loop = replace(loop, joints=(replace(loop.joints[0], compensation=law),))
    found = answer(one_joint(A), loop)["A"]
    assert (found.verdict, found.left) == ("undetermined", False)
    assert found.status == "it sticks and slips too often to be followed further"


def test_what_a_drive_cannot_move_is_looked_for_once_an_answer(monkeypatch):
    asked: list[int] = []
    monkeypatch.setattr(ending, "stalled", lambda rounds, place, others: asked.append(1) or {})
    ramp = Reference("ramp", velocity=0.05)
    rounds = Rounds(two_links(), Loop(0.0, 20.0, (JointLoop("A", 60.0, ramp), JointLoop("B", 30.0, ramp))))
    ending.answers(rounds, ending.Ending("rest", rounds.start({})))
    assert len(asked) == 1


def pressed(stiffness, effect="cable_spring", **values):
    entry = EffectEntry(effect, ("A",), {"A": {"stiffness": stiffness, **values}}, "linear")
    return replace(one_joint(A), effects=(entry,))


@pytest.mark.parametrize("sample_time", [0.0, 0.01])
@pytest.mark.parametrize("answer", [settle, shoot])
@pytest.mark.parametrize("arm", [pressed(0.05), pressed(200.0), pressed(20.0, "contact", position=0.05)])
def test_a_ramp_that_runs_away_from_its_joint_has_no_steady_error(loop_of, sample_time, answer, arm):
    """Against a spring c the error grows by v c/(Kp + c)."""
    loop = replace(loop_of(kp=60.0, sample_time=sample_time, velocity=0.1), duration=5.0)
    found, stiffness = answer(arm, loop)["A"], arm.effects[0].parameters["A"]["stiffness"]
    assert (found.verdict, found.steady_error, found.amplitude) == ("undetermined", None, None)
    told, growth = found.status.split(" by ")
    assert told == "it falls ever further behind its ramp: its error grows"
    assert growth.endswith(" rad/s")
    assert float(growth.split()[0]) == pytest.approx(0.1 * stiffness / (60.0 + stiffness), rel=2e-3)


@pytest.mark.long
@pytest.mark.parametrize("search", [settle_from, ending_of])
def test_an_error_that_stands_still_for_a_moment_is_no_rest(loop_of, search):
    """Where friction that depends on the position is largest, the error neither grows nor shrinks, for an instant."""
    wave = EffectEntry("position_dependent_friction", ("A",), {"A": {"sine": 0.3, "harmonic": 1.0}}, "one_wave")
    arm = replace(one_joint(COULOMB), effects=(wave,))
    rounds = Rounds(arm, replace(loop_of(kp=60.0, velocity=0.005), duration=5.0))
    found = ending.answers(rounds, search(rounds, starts(rounds)["own"]))["A"]
    assert (found.verdict, found.steady_error) == ("sliding_cycle", None)
    assert found.period == pytest.approx(2.0 * math.pi / 0.005, rel=1e-3)
    assert found.amplitude == pytest.approx(0.3 * COULOMB.C0 / 60.0, rel=1e-3)


@pytest.mark.long
@pytest.mark.parametrize("answer", [settle, shoot])
def test_stick_slip_on_the_way_to_a_wall_is_no_cycle(loop_of, answer):
    """It is on its way for the first 15 s."""
    loop = loop_of(kp=60.0, velocity=0.01, error=0.0)
    walled = pressed(20.0, "contact", position=0.05)
    before, after = (answer(walled, replace(loop, duration=duration))["A"] for duration in (12.0, 30.0))
    assert answer(one_joint(A), loop)["A"].verdict == "stick_slip"
    assert before.verdict in ("stick_slip", "undetermined")
    assert (after.verdict, after.amplitude) == ("undetermined", None)
    assert after.status.startswith("it falls ever further behind its ramp")


def test_the_record_of_a_joint_that_falls_behind_says_so(loop_of):
    seen = watched(simulate_loop(pressed(5.0), replace(loop_of(kp=60.0, velocity=0.1), duration=10.0)), 0)
    assert seen == "its error still grows, by 0.00769 rad/s"


def test_the_record_of_a_joint_that_never_moves_says_so(loop_of):
    seen = watched(simulate_loop(weak(one_joint(A)), loop_of(sample_time=0.005, velocity=0.05)), 0)
    assert seen == "it stands still while its reference moves on"


@pytest.mark.parametrize("sample_time", [0.0, 0.005])
@pytest.mark.parametrize("answer", [settle, shoot])
def test_a_ramp_ends_at_a_wall_within_the_duration(loop_of, sample_time, answer):
    wall = EffectEntry("contact", ("A",), {"A": {"stiffness": 2000.0, "position": 0.3}}, "linear")
    joint = replace(one_joint(A).joints[0], torque_limit=20.0)
    arm = replace(one_joint(A), joints=(joint,), effects=(wall,))
    loop = loop_of(kp=200.0, sample_time=sample_time, velocity=0.1)
    before, after = (answer(arm, replace(loop, duration=duration))["A"] for duration in (2.0, 10.0))
    assert (before.verdict, after.verdict) == ("rest", "undetermined")
    assert after.status == "the drive cannot move it: it gives 20 N m and no more"
