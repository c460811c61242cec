"""What re-tuning takes up of an effect: nearly all of a wrong mass, next to nothing of a delay."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.arm import Friction, Tolerance
from stribeck.withheld.arms import misinformed
from stribeck.withheld.bench import Bench
from stribeck.withheld.injections import Injection
from stribeck.withheld.motions import Motion, hold, multisine
from stribeck.withheld.retune import LIMIT, knobs, left_over
from stribeck.withheld.strength import strengths

BENCH = Bench(
    rate=125.0, bits=18, noise=1e-5, bandwidth=2.5, damping=0.8, integral=0.0, forward="inertial",
    velocity_filter=0.008, duration=3.0, kinds=(), one_by_one=False, channels=(),
)  # fmt: skip


def waving(*phases):
    sine = np.array([0.5, 0.15]), np.array([0.5, 1.6])
    return Motion("wave", 3.0, tuple(multisine(*sine, np.array([p, 2.0 * p]), 0.3, 3.0, 0.5) for p in phases))


@pytest.fixture
def arm(bench):
    return replace(bench.two_link(gravity=(9.81, 0.0)), tolerance=Tolerance(0.1, 0.2))


def test_a_payload_within_tolerance_has_little_left_and_a_delay_nearly_all(arm):
    hidden = [
        Injection("payload", "B", {"mass": 0.4}),  # 20 % of the link's mass, twice the tolerance
        Injection("payload", "B", {"mass": 1.6}),  # eight times
        Injection("torque_gain", "A", {"gain": 0.9}),
        Injection("delay", "A", {"time": 0.012}),
    ]
    motions = [waving(0.3, 1.9), waving(2.0, 0.5)]
    found = strengths(arm, arm, hidden, motions, BENCH)
    assert all(1.5 < one.plain < 8.0 and 0.0 <= one.left <= one.plain for one in found)
    small, large, gain, late = (one.left / one.plain for one in found)
    assert small < 0.2
    assert large > 0.35  # more than three tolerances can stand for
    assert gain < 0.35
    assert late > 0.8


def test_a_nominal_value_that_is_off_already_has_less_room(arm):
    wrong = replace(arm.joints[1], mass=arm.joints[1].mass / 1.25, com=(0.13 / 1.25, -0.01), inertia=0.02 / 1.25)
    nominal = replace(arm, joints=(arm.joints[0], wrong))
    payload = [Injection("payload", "B", {"mass": 0.6})]
    motions = [waving(0.3, 1.9)]
    (right,), (off,) = (strengths(arm, stated, payload, motions, BENCH) for stated in (arm, nominal))
    assert off.left > 1.5 * right.left


def test_a_velocity_filter_is_as_strong_as_it_is_seen_and_taken_up_by_nothing(arm):
    slow = [Injection("velocity_filter", "A", {"time": 0.02})]
    (seen,) = strengths(arm, arm, slow, [waving(0.3, 1.9)], replace(BENCH, channels=("dq",)))
    (unseen,) = strengths(arm, arm, slow, [waving(0.3, 1.9)], BENCH)
    assert seen.left == seen.plain > 1.0
    assert unseen == (0.0, 0.0)


def test_a_joint_that_rests_through_a_motion_makes_nothing_infinitely_strong(arm):
    """It sticks, so that its own floor there is nil."""
    still = Motion("one joint", 3.0, (waving(0.3, 1.9).curves[0], hold(0.2)))
    offset = [Injection("torque_offset", "B", {"offset": 0.4})]
    (found,) = strengths(replace(arm, gravity=(0.0, 0.0)), arm, offset, [waving(0.3, 1.9), still], BENCH)
    assert found.plain < 300.0


def test_left_over_is_ridge_regression_within_bounds(arm):
    """Against its closed form, where the torque is linear in one value; beyond the bound the rest stays."""
    rng = np.random.default_rng(0)
    column, effect = rng.standard_normal((2, 200, 2))
    (knob,) = [k for k in knobs(arm, arm) if (k.joint, k.name) == (1, "rotor_inertia")]
    weight = np.broadcast_to([3.0, 0.5], column.shape)

    def unexplained(other, size):
        return size * effect - column * (other.joints[1].rotor_inertia - arm.joints[1].rotor_inertia) / knob.sd

    left = left_over([knob], arm, lambda other: unexplained(other, 1.0), weight)
    z = np.sum(weight * column * effect) / (1.0 + np.sum(weight * column**2))
    assert left == pytest.approx(effect - z * column, abs=1e-9)
    far = left_over([knob], arm, lambda other: unexplained(other, 0.0) + 7.0 * column, weight)
    assert far == pytest.approx((7.0 - LIMIT) * column, abs=1e-8)


def test_values_that_look_alike_are_left_to_their_tolerances_however_quiet_the_floor(arm):
    """Two values of one column, weighed beyond what the digits of its square could hold beside the tolerances."""
    column = np.random.default_rng(0).standard_normal((200, 2))
    pair = [k for k in knobs(arm, arm) if (k.joint, k.name) in {(1, "rotor_inertia"), (0, "rotor_inertia")}]

    def unexplained(other):
        turned = (other.joints[k.joint].rotor_inertia - arm.joints[k.joint].rotor_inertia for k in pair)
        return column * (1.0 - sum(by / k.sd for by, k in zip(turned, pair, strict=True)))

    left = left_over(pair, arm, unexplained, np.full(column.shape, 1e18))
    assert np.abs(left).max() < 1e-9


def test_what_has_no_tolerance_is_not_turned_and_friction_stays_symmetric(arm, bench):
    names = [(k.joint, k.name, k.sides) for k in knobs(arm, arm)]
    assert len(names) == 18
    assert (0, "C0", ("friction", "backward")) in names
    flat = Friction(2.2, 0.0, 0.8, 0.04)
    uneven = replace(arm.joints[1], friction=flat, backward=replace(flat, C0=2.0), com=(0.13, 0.0))
    changed = replace(arm, joints=(arm.joints[0], uneven))
    own = [(k.name, k.sides) for k in knobs(changed, changed) if k.joint == 1]
    sides = [(name, (side,)) for side in ("friction", "backward") for name in ("C0", "C2")]
    assert own == [*((name, ()) for name in ("mass", "com_x", "inertia", "rotor_inertia")), *sides]
    knob = knobs(arm, arm)[5]
    turned = knob.turned(arm, 2.0).joints[0]
    assert turned.friction == turned.backward == replace(bench.A, C0=4.6 * 1.4)


def test_a_tolerance_of_a_value_s_own_counts(arm):
    """What is known exactly is not turned, and not off; what is known by itself is, by that."""
    first = replace(arm.joints[0], tolerance={"mass": 0.0, "inertia": 0.0, "com_x": 0.02, "C2": 0.0})
    own = replace(arm, joints=(first, *arm.joints[1:]))
    turned = {k.name: k.sd for k in knobs(own, own) if k.joint == 0}
    assert turned.keys() & {"mass", "inertia", "C2"} == set()
    assert turned["com_x"] == 0.02
    off = [misinformed(own, np.random.default_rng(k)).joints[0] for k in range(200)]
    assert {(joint.mass, joint.inertia, joint.friction.C2) for joint in off} == {
        (float(f"{first.mass:.4g}"), float(f"{first.inertia:.4g}"), float(f"{first.friction.C2:.4g}"))
    }
    assert np.std([joint.com[0] for joint in off]) == pytest.approx(0.02, rel=0.25)


def test_a_centre_of_mass_on_its_link_s_line_is_turned_but_for_the_last_link_s(arm):
    """By as much as re-tuning may, or what this leaves would count as a gap that it cannot see."""
    flat = replace(arm, joints=tuple(replace(joint, com=(joint.com[0], 0.0)) for joint in arm.joints))
    beside = {k.joint: k.sd for k in knobs(flat, flat) if k.name == "com_y"}
    assert beside == {0: flat.beside_the_line(0)}
    assert beside[0] > 0.0
