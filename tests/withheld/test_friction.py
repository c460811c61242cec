"""Dry friction: it holds, it lets go at break-away, it slides on Tustin's curve."""

import math
from dataclasses import replace

import numpy as np
import pytest

from stribeck.withheld.injections import Injection


def tustin(f, v):
    return f.C0 + f.C1 * math.exp(-abs(v) / f.alpha) + f.C2 * abs(v)


def ramp(rate):
    return lambda t: (rate * t)[:, None]


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_break_away_at_C0_plus_C1(bench, side):
    arm = bench.one_link(friction=bench.A)
    back = replace(bench.A, C0=3.0)
    arm = replace(arm, joints=(replace(arm.joints[0], backward=back),))
    _, trace = bench.open_loop(arm, ramp(side * 2.0), 5.0)
    expected = bench.A.C0 + bench.A.C1 if side > 0 else back.C0 + back.C1
    first = np.flatnonzero(trace.link_rate[:, 0] != 0.0)[0]
    assert abs(trace.tau[first - 1, 0]) == pytest.approx(expected, abs=0.005)
    assert np.all(trace.link[: first - 1, 0] == 0.0)


def test_stuck_arm_stays_where_it_is(bench):
    arm = bench.two_link((9.81, 0.0))
    start = ((0.3, 0.0), (0.2, 0.0))
    _, trace = bench.open_loop(arm, lambda t: np.zeros((len(t), 2)), 10.0, start=start)
    assert np.all(trace.link[-1] == [0.3, 0.2])
    assert np.all(trace.link_rate == 0.0)


def test_stuck_friction_balances_gravity(bench):
    from stribeck.withheld.plant import rigid_torque

    arm = bench.two_link((9.81, 0.0))
    pose = np.array([[0.3, 0.2]])
    _, trace = bench.open_loop(arm, lambda t: np.zeros((len(t), 2)), 0.1, start=((0.3, 0.0), (0.2, 0.0)))
    assert trace.friction[-1] == pytest.approx(-rigid_torque(arm, pose, 0 * pose, 0 * pose)[0], rel=1e-9)


def test_two_stuck_joints_carry_their_torques_exactly(bench):
    """Friction of one joint moves the other: both are found together, in every step."""
    arm = bench.two_link()
    swing = lambda t: np.stack([5 * np.sin(30 * t), 2 * np.sin(37 * t + 1)], axis=1)  # noqa: E731
    _, trace = bench.open_loop(arm, swing, 1.0)
    assert np.all(trace.link == 0.0)
    assert trace.friction[1:] == pytest.approx(trace.torque[1:], abs=1e-9)


@pytest.mark.parametrize("torque", [6.5, 8.0, 20.0, -7.0, -15.0])
def test_steady_sliding_is_on_tustins_curve(bench, torque):
    arm = bench.one_link(friction=bench.A)
    start = ((0.0, math.copysign(2.0, torque)),)
    _, trace = bench.open_loop(arm, lambda t: np.full((len(t), 1), torque), 3.0, start=start)
    v = trace.link_rate[-1, 0]
    assert abs(torque) == pytest.approx(tustin(bench.A, v), rel=1e-6)
    assert trace.friction[-1, 0] == pytest.approx(torque, rel=1e-6)


def test_coasting_to_rest_takes_the_time_of_the_closed_form(bench):
    coulomb = replace(bench.A, C1=0.0, C2=0.0)
    arm = bench.one_link(friction=coulomb)
    inertia = 0.01 + 0.02 + 1.0 * 0.25**2
    t, trace = bench.open_loop(arm, lambda t: np.zeros((len(t), 1)), 0.1, start=((0.0, 2.0),), rate=10000.0)
    stop = t[np.flatnonzero(trace.link_rate[:, 0] == 0.0)[0]]
    assert stop == pytest.approx(2.0 * inertia / coulomb.C0, abs=2e-4)
    assert trace.link[-1, 0] == pytest.approx(2.0**2 * inertia / coulomb.C0 / 2.0, rel=3e-3)


def test_power_balance_with_friction(bench):
    """Work of the command = kinetic energy + heat of friction."""
    arm = bench.two_link()
    swing = lambda t: np.stack([15 * np.sin(5 * t), 6 * np.sin(7 * t + 1)], axis=1)  # noqa: E731
    _, trace = bench.open_loop(arm, swing, 4.0, rate=20000.0)
    from stribeck.withheld.plant import rigid_torque

    mean = 0.5 * (trace.link_rate[1:] + trace.link_rate[:-1])
    work = np.sum(trace.torque[1:] * mean) / 20000.0
    heat = np.sum(trace.friction[1:] * mean) / 20000.0
    kinetic = 0.5 * rigid_torque(arm, trace.link, 0 * trace.link, trace.link_rate)[-1] @ trace.link_rate[-1]
    assert heat > 50.0
    assert np.all(trace.friction * trace.link_rate >= 0.0)
    assert work == pytest.approx(heat + kinetic, rel=1e-3)


def test_stick_slip_does_not_depend_on_the_step(bench):
    arm = bench.two_link()
    swing = lambda t: np.stack([9 * np.sin(3 * t), 4 * np.sin(4 * t + 1)], axis=1)  # noqa: E731
    ends = [bench.open_loop(arm, swing, 3.0, rate=500.0, substeps=s)[1] for s in (50, 100, 400)]
    assert np.mean(ends[2].link_rate == 0.0) > 0.05
    assert np.abs(ends[0].link - ends[2].link).max() < 2e-3
    assert np.abs(ends[1].link - ends[2].link).max() < 1e-3


def test_bristle_is_a_spring_before_it_slides(bench):
    arm = bench.one_link(friction=bench.A)
    hidden = (Injection("presliding", "A", {"stiffness": 2000.0, "damping": 10.0}),)
    _, trace = bench.open_loop(arm, lambda t: (0.2 * t)[:, None], 1.0, hidden)
    assert trace.link[-1, 0] == pytest.approx(0.2 / 2000.0, rel=0.1)
    # unloaded again it comes back, but only to the part that has not slid
    tri = lambda t: np.interp(t, [0, 2, 4], [0, 5.0, 0])[:, None]  # noqa: E731
    _, trace = bench.open_loop(arm, tri, 4.0, hidden)
    top, end = trace.link[:, 0].max(), trace.link[-1, 0]
    assert 5.0 / 2000.0 < top < 4 * 5.0 / 2000.0
    assert 0.1 * top < end < 0.9 * top


def test_bristle_slides_on_the_same_curve_and_does_not_creep(bench):
    arm = bench.one_link(friction=bench.A)
    hidden = (Injection("presliding", "A", {"stiffness": 2000.0, "damping": 10.0}),)
    _, trace = bench.open_loop(arm, lambda t: np.full((len(t), 1), 8.0), 3.0, hidden)
    assert trace.link_rate[-1, 0] > 0.3
    assert tustin(bench.A, trace.link_rate[-1, 0]) == pytest.approx(8.0, rel=1e-6)
    wobble = lambda t: (3.0 + 0.5 * np.sin(16 * np.pi * t))[:, None]  # noqa: E731
    _, trace = bench.open_loop(arm, wobble, 10.0, hidden)
    late = trace.link[5000:, 0]
    assert abs(late[:2500].mean() - late[2500:5000].mean()) < 1e-8


def test_bristle_step_is_implicit_enough(bench):
    """A stiff element at high speed, where an explicit one chatters, still gives Tustin's torque."""
    arm = bench.one_link(friction=bench.A)
    hidden = (Injection("presliding", "A", {"stiffness": 1e5, "damping": 50.0}),)
    _, trace = bench.open_loop(arm, lambda t: np.full((len(t), 1), 20.0), 2.0, hidden)
    assert trace.friction[-200:, 0] == pytest.approx(20.0, rel=1e-6)
