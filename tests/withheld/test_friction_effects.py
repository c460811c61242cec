"""Friction effects: what each does to a sliding or a sticking joint."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.withheld import Injection, Motion, record
from stribeck.withheld.motions import hold, multisine

HEAVY = {"inertia": 20.0}


def spin(bench, effect, params, torque=None, speed=1.0, duration=2.0, joint=None):
    """A heavy wheel that turns at almost constant speed, so that the friction level can be read at any time."""
    arm = bench.one_link(friction=bench.A, **(joint or HEAVY))
    force = torque or (lambda t: np.zeros_like(t))
    return bench.open_loop(
        arm, lambda t: force(t)[:, None], duration, (Injection(effect, "A", params),), ((0.0, speed),)
    )


def level(f, v):
    return f.C0 + f.C1 * np.exp(-np.abs(v) / f.alpha) + f.C2 * np.abs(v)


def test_asymmetry_is_forward_minus_backward(bench):
    for speed, sign in ((1.0, 0.5), (-1.0, -0.5)):
        _, trace = spin(bench, "asymmetric_friction", {"C0": 0.8, "C2": 0.4}, speed=speed)
        v = np.abs(trace.link_rate[1:, 0])
        assert np.abs(trace.friction[1:, 0]) == pytest.approx(level(bench.A, v) + sign * (0.8 + 0.4 * v), rel=1e-9)


def test_negative_damping_and_quadratic_damping_add_their_law(bench):
    _, trace = spin(bench, "negative_damping", {"amount": 1.2, "velocity": 0.3}, speed=0.5, duration=1.0)
    v = trace.link_rate[1:, 0]
    assert trace.friction[1:, 0] == pytest.approx(level(bench.A, v) + 1.2 * np.exp(-v / 0.3), rel=1e-9)
    _, trace = spin(
        bench, "negative_damping", {"amount": 1.2, "velocity": 0.3, "squared": 1.0}, speed=0.5, duration=1.0
    )
    v = trace.link_rate[1:, 0]
    assert trace.friction[1:, 0] == pytest.approx(level(bench.A, v) + 1.2 * np.exp(-((v / 0.3) ** 2)), rel=1e-9)
    _, trace = spin(bench, "quadratic_damping", {"coefficient": 0.7}, speed=-2.0)
    v = trace.link_rate[1:, 0]
    assert trace.friction[1:, 0] == pytest.approx(-level(bench.A, v) - 0.7 * v**2, rel=1e-9)


def test_frictional_lag_uses_the_speed_of_before(bench):
    lag = 0.05
    t, trace = spin(bench, "frictional_lag", {"time": lag}, lambda t: 300.0 * np.sin(8 * t), speed=2.6, duration=3.0)
    v = trace.link_rate[:, 0]
    assert v.min() > 0.0
    expected = level(bench.A, np.interp(t - lag, t, v))
    assert trace.friction[100:, 0] == pytest.approx(expected[100:], abs=2e-3)
    assert np.abs(trace.friction[100:, 0] - level(bench.A, v)[100:]).max() > 0.3


def test_the_viscous_part_may_keep_to_the_speed_of_now(bench):
    lag, force = 0.05, lambda t: 300.0 * np.sin(8 * t)
    t, trace = spin(bench, "frictional_lag", {"time": lag, "drop": 1.0}, force, speed=2.6, duration=3.0)
    v = trace.link_rate[:, 0]
    before = np.interp(t - lag, t, v)
    expected = level(bench.A, before) + bench.A.C2 * (v - before)
    assert trace.friction[100:, 0] == pytest.approx(expected[100:], abs=2e-3)


def test_break_away_grows_with_the_time_at_rest(bench):
    def break_away(wait):
        arm = bench.one_link(friction=bench.A)
        force = lambda t: np.where(t < wait, 0.0, 50.0 * (t - wait))[:, None]  # noqa: E731
        hidden = (Injection("dwell_time", "A", {"rise": 2.0, "time": 1.0}),)
        t, trace = bench.open_loop(arm, force, wait + 0.5, hidden)
        first = np.flatnonzero(trace.link_rate[:, 0])[0]
        return t[first], trace.friction[first - 1, 0]

    still = bench.A.C0 + bench.A.C1
    for wait in (0.0, 0.5, 2.0, 8.0):
        rest, found = break_away(wait)
        assert found == pytest.approx(still + 2.0 * (1 - np.exp(-rest)), abs=0.07)
    _, trace = spin(bench, "dwell_time", {"rise": 2.0, "time": 1.0}, speed=1.0)
    v = trace.link_rate[500:, 0]
    assert trace.friction[500:, 0] == pytest.approx(level(bench.A, v), rel=1e-3)  # gone once it slides


def test_warm_up_changes_the_level_and_stays_warm_between_runs(bench):
    wheel = {"change": -0.4, "time": 3.0, "power": 5.0}
    _, trace = spin(bench, "history", wheel, lambda t: 0 * t + 5.9, speed=1.0, duration=12.0, joint={"inertia": 200.0})
    v, power = trace.link_rate[:, 0], trace.friction[:, 0] * trace.link_rate[:, 0]
    factor = trace.friction[1:, 0] / level(bench.A, v[1:])
    warmth = np.zeros(len(v))
    for i in range(1, len(v)):
        warmth[i] = warmth[i - 1] + 1e-3 / 3.0 * (power[i] / 5.0 - warmth[i - 1])
    assert factor == pytest.approx(1.0 - 0.4 * warmth[1:], abs=1e-3)
    assert factor[-1] < 0.75
    arm = bench.two_link()
    swing = multisine(np.array([0.4]), np.array([0.5]), np.array([0.0]), 0.0, 3.0)
    motion = Motion("swing", 3.0, (swing, hold(0.0)))
    hidden = [Injection("history", "A", {"change": -0.5, "time": 60.0, "power": 0.5})]
    first, second = record(arm, hidden, [motion, motion], rate=500.0)
    assert np.abs(second.tau[500:1000, 0]).mean() < 0.97 * np.abs(first.tau[500:1000, 0]).mean()


def test_warm_up_may_go_by_time_alone(bench):
    timed = {"change": -0.4, "time": 3.0, "power": 0.0}
    t, trace = spin(bench, "history", timed, speed=1.0, duration=6.0, joint={"inertia": 200.0})
    factor = trace.friction[1:, 0] / level(bench.A, trace.link_rate[1:, 0])
    assert factor == pytest.approx(1.0 - 0.4 * (1.0 - np.exp(-t[1:] / 3.0)), abs=1e-3)


def loaded(bench, values, speed):
    """A joint with a heavy link and rotor, driven to and fro, whose friction goes with its load."""
    joint = {"inertia": 20.0, "rotor_inertia": 5.0}
    return spin(bench, "load_dependent_friction", values, lambda t: 30.0 * np.sin(6 * t), speed=speed, joint=joint)[1]


def test_position_and_load_enter_the_level(bench):
    _, trace = spin(bench, "position_dependent_friction", {"amplitude": 1.5, "harmonic": 3.0, "phase": 0.5})
    middle = trace.motor[1:, 0] - trace.motor_rate[1:, 0] * 2e-5
    wave = 1.5 * np.sin(3.0 * middle + 0.5)
    assert trace.friction[1:, 0] == pytest.approx(level(bench.A, trace.link_rate[1:, 0]) + wave, abs=1e-5)
    twice = {"overtone": 0.4, "overtone_phase": 0.2}
    _, trace = spin(bench, "position_dependent_friction", {"amplitude": 1.5, "harmonic": 3.0, "phase": 0.5, **twice})
    middle = trace.motor[1:, 0] - trace.motor_rate[1:, 0] * 2e-5
    wave = 1.5 * np.sin(3.0 * middle + 0.5) + 0.4 * np.sin(6.0 * middle + 0.2)
    assert trace.friction[1:, 0] == pytest.approx(level(bench.A, trace.link_rate[1:, 0]) + wave, abs=1e-5)
    trace = loaded(bench, {"ratio": 0.1}, 2.0)
    v = trace.link_rate[5:, 0]
    assert trace.friction[5:, 0] == pytest.approx(level(bench.A, v) + 0.1 * np.abs(trace.load[5:, 0]), rel=2e-3)
    link = 20.0 + 1.0 * 0.25**2  # what the rotor passes on is what moves the link
    acceleration = np.gradient(trace.link_rate[:, 0], 1e-3)[5:-5]
    assert trace.load[5:-5, 0] == pytest.approx(link * acceleration, abs=0.15)


@pytest.mark.parametrize("speed", [2.0, -2.0])
def test_what_enters_a_gear_is_its_own_friction_too(bench, speed):
    trace = loaded(bench, {"ratio": 0.3, "input": 1.0}, speed)
    friction, load = trace.friction[5:, 0], trace.load[5:, 0]
    entering = np.abs(load + friction)
    assert np.abs(friction) == pytest.approx(level(bench.A, trace.link_rate[5:, 0]) + 0.3 * entering, rel=4e-3)


def test_friction_may_go_with_the_motor_s_torque(bench):
    trace = loaded(bench, {"ratio": 0.3, "input": 2.0}, 2.0)
    more = trace.friction[5:, 0] - level(bench.A, trace.link_rate[5:, 0])
    assert more == pytest.approx(0.3 * np.abs(trace.torque[5:, 0]), abs=0.02)


@pytest.mark.parametrize("speed", [2.0, -2.0])
def test_friction_may_go_with_what_it_leaves_of_the_motor_s_torque(bench, speed):
    trace = loaded(bench, {"ratio": 0.3, "input": 4.0}, speed)
    rate = trace.link_rate[5:, 0]
    dry = np.abs(trace.friction[5:, 0]) - bench.A.C2 * np.abs(rate)
    left = trace.torque[5:, 0] - np.sign(rate) * dry
    assert dry == pytest.approx(level(bench.A, rate) - bench.A.C2 * np.abs(rate) + 0.3 * np.abs(left), abs=0.02)


def test_friction_may_go_with_the_weight_that_a_joint_holds(bench):
    arm = replace(bench.one_link(friction=bench.A), gravity=(0.0, -9.81))
    hidden = (Injection("load_dependent_friction", "A", {"ratio": 0.3, "input": 3.0}),)
    _, trace = bench.open_loop(arm, lambda t: 30.0 * np.sin(6 * t)[:, None], 2.0, hidden, ((0.3, 2.0),))
    moves = (np.abs(trace.link_rate[:, 0]) > 0.1) & (np.arange(len(trace.link_rate)) > 5)
    more = np.abs(trace.friction[moves, 0]) - level(bench.A, trace.link_rate[moves, 0])
    link = arm.joints[0]
    weight = (
        9.81 * link.mass * (link.com[0] * np.cos(trace.link[moves, 0]) - link.com[1] * np.sin(trace.link[moves, 0]))
    )
    assert np.ptp(np.abs(weight)) > 1.0
    assert more == pytest.approx(0.3 * np.abs(weight), abs=0.02)


def test_friction_jumps_stay_within_their_size(bench):
    from stribeck.withheld.special import Disturbance

    t = np.arange(20000) * 1e-3
    x = Disturbance("factor", {"change": 0.3, "rate": 2.0}).signal(t, np.random.default_rng(1))
    assert np.all(np.abs(x - 1.0) <= 0.3)
    assert x.min() < 0.8
    assert x.max() > 1.2
    assert 20 < np.count_nonzero(np.diff(x)) < 65
