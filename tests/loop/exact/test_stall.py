"""Joints that the drive cannot move, however much is asked of it."""

from dataclasses import replace

import pytest

from stribeck.arm import EffectEntry
from stribeck.loop.exact.settle import settle
from stribeck.loop.exact.shooting import shoot
from stribeck.loop.watched import watched
from stribeck.simulate import JointLoop, Loop, Reference, simulate

from .conftest import A, one_joint, two_links

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


def test_the_record_of_a_joint_that_never_moves_says_so(loop_of):
    seen = watched(simulate(weak(one_joint(A)), loop_of(sample_time=0.005, velocity=0.05)), 0)
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
