"""Shooting against closed forms: the coth law, critical ratios, unbounded growth, the figures that are known."""

import math
from dataclasses import replace

import numpy as np
import pytest

from stribeck.arm import Friction
from stribeck.loop.exact.critical import fold_velocity, k_critical
from stribeck.loop.exact.settle import settle
from stribeck.loop.exact.shooting import shoot

from .conftest import B


@pytest.mark.parametrize("zeta", [0.1, 0.5, 0.9, 0.99, 0.999])
@pytest.mark.parametrize(("ratio", "at_zero"), [(1.1, "set_valued"), (1.5, "error_sign")])
def test_coth_law(coulomb, loop_of, ratio, at_zero, zeta):
    """Its period grows without bound towards critical damping; neither window nor threshold may cut it off."""
    found = shoot(coulomb, loop_of(ratio, at_zero, zeta=zeta))["A"]
    root = math.sqrt(1.0 - zeta**2)
    assert found.verdict == "sliding_cycle"
    assert found.amplitude == pytest.approx((ratio - 1) * 5.0 / 30.0 / math.tanh(math.pi * zeta / (2 * root)), rel=1e-8)
    assert found.period == pytest.approx(2 * math.pi / (math.sqrt(30.0) * root), rel=1e-6)
    assert found.stick_fraction == 0.0
    assert found.stable
    rho = math.exp(-math.pi * zeta / root)
    assert found.multipliers == pytest.approx([rho**2], abs=1e-5)


def test_critical_damping_rests(coulomb, loop_of):
    found = shoot(coulomb, loop_of(1.3, zeta=1.0))["A"]
    assert (found.verdict, found.amplitude, found.period) == ("rest", None, None)
    assert abs(found.steady_error) == pytest.approx(0.3 * 5.0 / 30.0, rel=1e-4)


@pytest.mark.parametrize("zeta", [0.2, 0.5])
@pytest.mark.parametrize("at_zero", ["set_valued", "error_sign", "zero", "hold"])
def test_critical_ratio(coulomb, loop_of, zeta, at_zero):
    rho = math.exp(-math.pi * zeta / math.sqrt(1.0 - zeta**2))
    expected = {"zero": 2.0 / (1.0 + rho), "hold": 1.0 / rho}.get(at_zero, 1.0)
    assert k_critical(coulomb, loop_of(1.0, at_zero, zeta=zeta), "A") == pytest.approx(expected, rel=2e-5)


def test_a_ratio_that_does_not_matter_is_not_critical(joint_a, coulomb, loop_of):
    assert k_critical(joint_a, loop_of(1.0, kind="feedforward", zeta=0.3), "A") is None
    assert k_critical(joint_a, loop_of(zeta=0.3), "A") is None
    assert k_critical(joint_a, loop_of(1.0, "zero", ki=30.0), "A") == 0.0  # it hunts without compensation


def test_growth_is_unbounded_over_the_viscous_limit(joint_a, loop_of):
    limit = 1.0 + 2.0 * 0.3 * math.sqrt(30.0) / 1.5
    for share, unbounded in ((0.98, False), (1.02, True)):
        found = shoot(joint_a, loop_of(limit * share, zeta=0.3))["A"]
        assert (found.verdict == "unbounded") == unbounded
        assert found.cycles != unbounded


def test_known_cycles(joint_a, loop_of):
    over = shoot(joint_a, loop_of(1.3, zeta=0.5))["A"]
    assert (over.verdict, over.stable) == ("sliding_cycle", True)
    assert (over.amplitude, over.period) == pytest.approx((0.0757, 1.345), rel=1e-3)
    hunting = shoot(joint_a, loop_of(0.9, "zero", ki=30.0))["A"]
    assert (hunting.verdict, hunting.stable) == ("hunting", True)
    assert hunting.amplitude == pytest.approx(0.091, rel=5e-3)
    assert 0.7 < hunting.stick_fraction < 0.8


def test_noise_makes_the_critically_damped_loop_cycle_and_a_dead_band_stops_it(joint_a, loop_of):
    noisy = {"sample_time": 0.0125, "encoder_noise": 2e-5}
    assert shoot(joint_a, loop_of(1.3, "zero", **noisy))["A"].verdict == "undetermined"
    found = settle(joint_a, loop_of(1.3, "zero", **noisy))["A"]
    assert found.verdict == "sliding_cycle"
    assert found.amplitude == pytest.approx(0.0609, rel=0.03)
    assert found.period == pytest.approx(3.8, rel=0.06)
    band = 5.0 * math.sqrt(2.0) * 2e-5 / 0.0125
    assert settle(joint_a, loop_of(1.3, "zero", dead_band=band, **noisy))["A"].verdict == "rest"


@pytest.mark.parametrize(("coulomb", "said"), [(5.0, True), (0.0, False)])
def test_noise_starts_a_cycle_only_where_there_is_friction_to_compensate(engine_of, loop_of, coulomb, said):
    found = shoot(engine_of(Friction(coulomb, 0.0, 1.5, 0.05)), loop_of(1.3, "zero", zeta=1.5))["A"]
    assert found.verdict == "rest"
    assert ("noise" in found.status) is said


@pytest.mark.parametrize(("zeta", "fold"), [(1.0, 0.010), (0.5, 0.039), (0.25, 0.072)])
def test_fold_velocity(joint_b, loop_of, zeta, fold):
    found = fold_velocity(joint_b, loop_of(zeta=zeta), "A")
    assert found == pytest.approx(fold, abs=6e-4)
    for share, verdict in ((0.99, "stick_slip"), (1.01, "rest")):
        assert shoot(joint_b, loop_of(zeta=zeta, velocity=share * found))["A"].verdict == verdict


def test_a_fold_as_fast_as_a_motor_is_found(joint_b, engine_of, loop_of):
    """The same joint with a thousandth of its unit of time."""
    scale = 1000.0
    fast = Friction(B.C0 * scale**2, B.C1 * scale**2, B.C2 * scale, B.alpha * scale)
    found = fold_velocity(engine_of(fast), loop_of(zeta=0.5, kp=30.0 * scale**2), "A")
    assert found == pytest.approx(scale * fold_velocity(joint_b, loop_of(zeta=0.5), "A"), rel=1e-4)


def test_a_ramp_that_leads_far_is_no_unbounded_motion(engine_of, loop_of):
    """Sliding along a ramp of 100 rad/s it settles with a time constant of 20 s, and so thousands of radians away."""
    engine = engine_of(Friction(5.0, 0.0, 0.1, 0.05))
    found = shoot(engine, loop_of(zeta=0.0, kp=30.0, sample_time=1e-3, velocity=100.0))["A"]
    assert found.verdict == "rest"
    assert found.steady_error == pytest.approx((5.0 + 0.1 * 100.0) / 30.0, rel=1e-3)


@pytest.mark.parametrize("sample_time", [0.0, 0.0125])
@pytest.mark.parametrize("method", [shoot, settle])
def test_a_backward_ramp_is_the_mirror_image_of_a_forward_one(joint_a, loop_of, method, sample_time):
    ways = [method(joint_a, loop_of(zeta=0.1, velocity=v, sample_time=sample_time))["A"] for v in (0.02, -0.02)]
    seen = [(way.amplitude, way.period, way.peak_velocity, way.stick_fraction) for way in ways]
    assert [way.verdict for way in ways] == ["stick_slip", "stick_slip"]
    assert seen[1] == pytest.approx(seen[0], rel=1e-9)


@pytest.mark.long
def test_the_fold_of_a_backward_ramp_is_that_of_its_own_friction(joint_b, loop_of):
    steep = replace(B, C1=2.4, alpha=0.12)
    joint = replace(joint_b.arm.joints[0], backward=steep)
    forward, backward = (replace(joint_b.arm, joints=(side,)) for side in (replace(joint, friction=steep), joint))
    found = fold_velocity(backward, loop_of(zeta=0.5, velocity=-0.01), "A")
    assert found == fold_velocity(forward, loop_of(zeta=0.5, velocity=0.01), "A")
    assert found > 2.0 * fold_velocity(backward, loop_of(zeta=0.5, velocity=0.01), "A")


@pytest.mark.long
def test_a_fold_is_that_of_the_place_and_not_of_what_the_ramp_leads_to(joint_a, loop_of):
    """Gravity changes along the way, but hardly how the joint slides on where it is."""
    loop = loop_of(kp=60.0, velocity=0.05)
    heavy = replace(joint_a.arm, joints=(replace(joint_a.arm.joints[0], com=(0.05, 0.0)),), gravity=(9.81, 0.0))
    assert fold_velocity(heavy, loop, "A") == pytest.approx(fold_velocity(joint_a, loop, "A"), rel=0.02)


def test_trace_is_one_period(joint_a, loop_of):
    found = shoot(joint_a, loop_of(0.9, "zero", ki=30.0))["A"]
    trace = found.trace
    assert trace.time[-1] == pytest.approx(found.period)
    assert 0.5 * np.ptp(trace.position) == pytest.approx(found.amplitude, rel=1e-6)
    assert np.abs(trace.velocity).max() == pytest.approx(found.peak_velocity, rel=1e-3)
    assert trace.stuck.mean() == pytest.approx(found.stick_fraction, abs=0.01)
    assert trace.position[-1] == pytest.approx(trace.position[0], abs=1e-8)
    assert (~trace.stuck).sum() > 700  # however long it sticks
    assert (trace.velocity[trace.stuck] == 0.0).all()
