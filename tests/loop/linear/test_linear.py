"""Linear loops: against closed forms, python-control's own discretisation, and the figures for the largest gain."""

import math
import time
from dataclasses import replace

import control as ct
import numpy as np
import pytest

from stribeck.arm import Arm, EffectEntry, Friction, Joint
from stribeck.errors import InputError
from stribeck.loop.linear import (
    Assembly,
    KpMax,
    OperatingPoint,
    assemble,
    free,
    kp_max,
    linearise,
    margins,
    root_locus,
    sliding,
    stuck,
)
from stribeck.loop.linear.gains import TOO_LATE
from stribeck.loop.linear.margins import response
from stribeck.loop.linear.sampled import lagged, sampled
from stribeck.simulate import Compensation, JointLoop, Loop, Reference

A = Friction(5.0, 1.25, 1.5, 0.05)
B = Friction(2.2, 0.6, 0.8, 0.04)
STEP = 0.0125


def one_joint(*effects: EffectEntry, friction: Friction = A) -> Arm:
    joint = Joint("A", "revolute", 0.3, 1.0, (0.0, 0.0), 0.5, 0.5, friction, friction)
    return Arm("one joint", (0.0, 0.0), (joint,), effects=effects)


def two_links(*effects: EffectEntry) -> Arm:
    joints = (
        Joint("A", "revolute", 0.35, 4.0, (0.17, 0.02), 0.06, 0.15, A, A),
        Joint("B", "revolute", 0.26, 2.0, (0.13, -0.01), 0.02, 0.08, B, B),
    )
    return Arm("two links", (9.81, 0.0), joints, effects=effects)


def entry(effect: str, joint: str, **values: float) -> EffectEntry:
    return EffectEntry(effect, (joint,), {joint: values})


def controlled(kp: float = 60.0, joint: str = "A", **values: object) -> JointLoop:
    return JointLoop(joint, kp, Reference("regulate"), **values)  # type: ignore[arg-type]


def loop(*joints: JointLoop, step: float = STEP) -> Loop:
    return Loop(step, 20.0, joints or (controlled(),))


@pytest.mark.parametrize(
    ("delay", "lag", "stability", "ms2"),
    [(0, 0.0, 3150, 655), (1, 0.0, 662, 150), (2, 0.0, 290, 66), (1, 0.02, 282.5, 56.5)],
)
def test_largest_gain_at_critical_damping(delay: int, lag: float, stability: float, ms2: float) -> None:
    arm, given = one_joint(), loop(controlled(delay_samples=delay, actuator_lag=lag))
    found = kp_max(assemble(arm, given, free(arm, given)), "A")
    assert found.stability == pytest.approx(stability, rel=2e-3)
    assert found.ms2 == pytest.approx(ms2, rel=3e-3)


def test_largest_gain_is_where_a_pole_leaves_the_circle() -> None:
    arm, given = one_joint(), loop(controlled(delay_samples=2))
    linear = assemble(arm, given, free(arm, given))
    top = kp_max(linear, "A").stability
    assert top is not None
    radii = [np.abs(poles).max() for poles in root_locus(linear, "A", [0.999 * top, 1.001 * top])]
    assert radii[0] < 1.0 < radii[1]


@pytest.mark.parametrize(
    ("step", "kv", "why"),
    [(0.0, None, "no gain is too high for this linear model"), (STEP, 0.0, "no gain makes this loop stable")],
)
def test_without_a_largest_gain_it_says_why(step: float, kv: float | None, why: str) -> None:
    arm, given = one_joint(), loop(controlled(kv=kv), step=step)
    found = kp_max(assemble(arm, given, free(arm, given)), "A")
    assert (found.stability, found.why) == (None, why)


def test_a_delay_of_many_samples_is_cheap_and_one_of_very_many_is_left_out() -> None:
    """The largest gain of a dead time T and a rigid joint goes as 1/T^2."""
    arm, begin = one_joint(), time.process_time()
    tops = []
    for late in (50, 100, 1000):
        given = loop(controlled(delay_samples=late))
        tops.append(kp_max(assemble(arm, given, free(arm, given)), "A"))
    assert time.process_time() - begin < 10.0
    assert tops[0].stability == pytest.approx(tops[1].stability * (101.0 / 51.0) ** 2, rel=0.03)
    assert tops[0].ms2 == pytest.approx(tops[1].ms2 * (101.0 / 51.0) ** 2, rel=0.03)
    assert tops[2] == KpMax(None, None, TOO_LATE)


@pytest.mark.parametrize(("kp", "stable"), [(1.9, False), (2.0, True)])
def test_margins_are_those_of_where_the_steps_end(kp: float, stable: bool) -> None:
    """Upright a pendulum falls with less than gravity's stiffness there, m g c = 1.962 N m/rad."""
    hanging = replace(one_joint().joints[0], com=(0.2, 0.0))
    arm = Arm("pendulum", (9.81, 0.0), (hanging,))
    given = loop(JointLoop("A", kp, Reference("steps", times=(0.0, 1.0), values=(1.0, math.pi)), kv=1.0))
    assert margins(assemble(arm, given, free(arm, given)), "A").stable == stable


def test_friction_slope_and_inertia_at_a_sliding_point() -> None:
    arm, given = one_joint(), loop()
    v = 0.03
    plant = linearise(arm, sliding(arm, given, v)).system
    slope = A.C2 - A.C1 / A.alpha * math.exp(-v / A.alpha)
    assert np.sort(plant.poles().real) == pytest.approx([0.0, -slope], abs=1e-9)
    assert plant.input_labels == ["tau[A]"]
    assert plant.output_labels == ["q[A]", "dq[A]"]


def test_a_stuck_bristle_is_a_spring_and_a_stuck_joint_without_one_does_not_move() -> None:
    bristle, given = entry("presliding", "A", stiffness=1500.0, damping=5.0), loop()
    arm = one_joint(bristle)
    plant = linearise(arm, stuck(arm, given)).system
    exact = ct.ss(ct.tf([1.0], [1.0, 5.0 + A.C2, 1500.0]))
    omega = np.geomspace(1.0, 300.0, 20)
    assert ct.frequency_response(plant[0, 0], omega).complex == pytest.approx(
        ct.frequency_response(exact, omega).complex, rel=1e-9
    )
    assert linearise(one_joint(), stuck(one_joint(), given)).joints == ()


def test_a_flexible_joint_has_the_resonance_of_its_two_inertias() -> None:
    arm = one_joint(entry("joint_flexibility", "A", stiffness=400.0, damping=0.0))
    poles = linearise(arm, free(arm, loop())).system.poles()
    assert np.abs(poles.imag).max() == pytest.approx(math.sqrt(400.0 / 0.25), rel=1e-9)


def test_actuator_effects_count_at_the_command_not_at_the_motor() -> None:
    arm, given = one_joint(entry("actuator_lag", "A", time_constant=0.05)), loop()
    at_command = linearise(arm, free(arm, given)).system
    at_motor = linearise(arm, free(arm, given), at_motor=True).system
    assert sorted(at_command.poles().real) == pytest.approx([-20.0, 0.0, 0.0])
    assert at_motor.nstates == 2


@pytest.mark.parametrize(
    ("lossy", "same"),
    [
        (entry("torque_dead_zone", "A", width=0.3), ()),
        (replace(entry("torque_dead_zone", "A", width=0.3), law="threshold"), ()),
        (
            entry("backlash", "A", gap=0.01, stiffness=5e3, damping=5.0),
            (entry("joint_flexibility", "A", stiffness=5e3, damping=5.0),),
        ),
    ],
)
def test_what_loses_little_torques_or_motions_is_linear_beyond_them(
    lossy: EffectEntry, same: tuple[EffectEntry, ...]
) -> None:
    """However small, it would seem that no gain holds the joint."""
    pd = loop(controlled(kp=30.0, kv=5.0))
    found, expected = (kp_max(assemble(arm, pd, free(arm, pd)), "A") for arm in (one_joint(lossy), one_joint(*same)))
    assert found.stability is not None
    assert (found.stability, found.ms2) == pytest.approx((expected.stability, expected.ms2), rel=1e-9)


def test_a_fractional_delay_is_exact() -> None:
    plant = ct.ss(ct.tf([3.0], [1.0, 2.0]))
    found = sampled(plant, 0.1, np.array([0.13]))
    time, held = 0.1 * np.arange(30), np.random.default_rng(0).standard_normal(30)
    fine = np.arange(3000) * 1e-3
    late = np.where(fine < 0.13, 0.0, held[np.maximum((fine - 0.13 + 1e-9) // 0.1, 0).astype(int)])
    exact = ct.forced_response(ct.c2d(plant, 1e-3), fine, late).outputs[::100]
    assert ct.forced_response(found, time, held).outputs == pytest.approx(exact, abs=1e-9)


def test_whole_delays_lag_and_hold_as_python_control_has_them() -> None:
    plant = ct.ss(ct.tf([1.0], [1.0, 0.0, 0.0]))
    found = sampled(lagged(plant, np.array([0.02])), STEP, np.array([2 * STEP]))
    known = ct.c2d(ct.ss(ct.tf([1.0], [0.02, 1.0])) * plant, STEP) * ct.ss(ct.tf([1.0], [1.0, 0.0, 0.0], STEP))
    omega = np.geomspace(0.1, 240.0, 30)
    ours = ct.frequency_response(found, omega).complex
    assert ours == pytest.approx(ct.frequency_response(known, omega).complex, rel=1e-8)


@pytest.mark.parametrize("effect", [entry("delay", "A", time=0.02), entry("time_shift", "A", time=0.02)])
def test_the_arms_own_delay_counts(effect: EffectEntry) -> None:
    given = loop()
    whole = loop(controlled(delay_samples=2))
    with_effect = kp_max(assemble(one_joint(effect), given, free(one_joint(effect), given)), "A").stability
    without = kp_max(assemble(one_joint(), given, free(one_joint(), given)), "A").stability
    two = kp_max(assemble(one_joint(), whole, free(one_joint(), whole)), "A").stability
    assert with_effect is not None
    assert two is not None
    assert without is not None
    assert two < with_effect < without  # 1.6 samples of delay


def test_continuous_pd_has_the_margins_of_the_textbook() -> None:
    arm, given = one_joint(), loop(controlled(25.0, kv=4.0), step=0.0)
    found = margins(assemble(arm, given, free(arm, given)), "A")
    exact = ct.tf([4.0, 25.0], [1.0, 0.0, 0.0])
    _, phase, _, crossing = ct.margin(exact)
    assert found.stable
    assert found.gain_margin == math.inf
    assert found.phase_margin == pytest.approx(math.radians(phase), rel=1e-4)
    assert found.delay_margin == pytest.approx(math.radians(phase) / crossing, rel=1e-4)
    assert found.damping == pytest.approx(0.4, rel=1e-9)
    omega = np.geomspace(0.1, 100.0, 20_000)
    value = exact(1j * omega)
    assert found.sensitivity_peak == pytest.approx(np.abs(1.0 / (1.0 + value)).max(), rel=1e-6)
    assert found.bandwidth == pytest.approx(omega[np.abs(value / (1.0 + value)) >= math.sqrt(0.5)].max(), rel=1e-3)


@pytest.mark.parametrize("velocity", ["true", "finite_difference"])
def test_a_sampled_loop_becomes_unstable_at_its_gain_margin(velocity: str) -> None:
    """With true velocity a pole leaves through z = -1, at the Nyquist frequency, where a search ends."""
    arm = one_joint()

    def gained(times: float) -> Assembly:
        given = loop(controlled(60.0 * times, kv=9.0 * times, velocity=velocity))
        return assemble(arm, given, free(arm, given))

    found = margins(gained(1.0), "A").gain_margin
    assert 1.0 < found < 1000.0
    assert [gained(found * part).is_stable("A") for part in (0.99, 1.01)] == [True, False]
    assert margins(gained(1.0), "A").sensitivity_peak >= 0.999 / (1.0 - 1.0 / found)


@pytest.mark.parametrize("late", [0, 7])
@pytest.mark.parametrize("velocity", ["true", "finite_difference"])
def test_the_sampled_law_with_filter_and_integral(velocity: str, late: int) -> None:
    """Against the difference equations of the law, written out."""
    arm = one_joint()
    given = loop(controlled(60.0, kv=9.0, ki=20.0, velocity=velocity, velocity_filter=0.01, delay_samples=late))
    linear = assemble(arm, given, free(arm, given))
    z = np.exp(1j * np.array([0.5, 5.0, 50.0]) * STEP)
    gain = 1.0 - math.exp(-STEP / 0.01)
    position = STEP**2 / 2.0 * (z + 1.0) / (z - 1.0) ** 2
    raw = STEP / (z - 1.0) if velocity == "true" else position * (1.0 - 1.0 / z) / STEP
    law = 60.0 * position + 9.0 * gain / (1.0 - (1.0 - gain) / z) * raw + 20.0 * STEP / (z - 1.0) * position
    found = response(linear.broken("A"), np.array([0.5, 5.0, 50.0]))
    assert found == pytest.approx(law / z**late, rel=1e-8)


def test_a_held_joint_stands_on_a_base_that_slides_all_the_same() -> None:
    """Beside the moving joint's own the base's two poles, at its frequency with the arm's weight; not at zero."""
    values = {"stiffness": 5000.0, "damping": 10.0, "mass": 6.0, "direction": 0.4}
    arm = two_links(EffectEntry("base_flexibility", ("A",), {"A": values}, "sliding"))
    point = OperatingPoint((0.2, 0.6), (0.0, 0.0), ("clamped", "free"))
    flat = replace(arm, gravity=(0.0, 0.0))
    linear = linearise(flat, point)
    assert linear.joints == (1,)
    assert linear.system.nstates == 4
    rings = max(linear.system.poles(), key=abs)
    assert abs(rings) == pytest.approx(math.sqrt(5000.0 / 12.0), rel=0.05)
    assert linearise(flat, OperatingPoint((0.2, 0.6), (0.0, 0.0), ("clamped", "clamped"))).system.nstates == 0


def test_two_joints_coupled_and_one_held() -> None:
    arm = two_links()
    both = loop(controlled(joint="A"), controlled(40.0, joint="B"))
    linear = assemble(arm, both, free(arm, both))
    a, b, c = (np.asarray(linear.plant.A), np.asarray(linear.plant.B), np.asarray(linear.plant.C))
    assert linear.plant.nstates == 4
    found = np.sort_complex(linear.poles())
    # broken at A and closed again by hand gives the same poles as closing both at once
    opened = linear.broken("A").system
    again = np.linalg.eigvals(np.asarray(opened.A) - np.asarray(opened.B) @ np.asarray(opened.C))
    assert np.sort_complex(again) == pytest.approx(found, abs=1e-9)
    assert c.shape == (4, 4)
    assert np.abs(b[:, 1]).max() > 0.0
    assert np.linalg.matrix_rank(a) == 4
    alone = loop(controlled(joint="A"))
    held = assemble(arm, alone, free(arm, alone))
    assert held.plant.nstates == 2
    assert held.inertia[0] == pytest.approx(linear.inertia[0])


def test_compensation_takes_the_slope_of_friction_away() -> None:
    arm = one_joint()
    whole = loop(controlled(25.0, kv=4.0, compensation=Compensation("feedback", 1.0)), step=0.0)
    linear = assemble(arm, whole, sliding(arm, whole, 0.2))
    assert np.sort_complex(linear.poles()) == pytest.approx(np.sort_complex(np.roots([1.0, 4.0, 25.0])), rel=1e-9)


def test_an_unstable_loop_is_labelled() -> None:
    arm, given = one_joint(), loop(controlled(5000.0))
    found = margins(assemble(arm, given, free(arm, given)), "A")
    assert not found.stable
    assert math.isnan(found.sensitivity_peak)


@pytest.mark.parametrize(
    ("velocity", "contact", "says"),
    [((0.1,), ("sticks",), "cannot move"), ((0.0,), ("slides",), "must move"), ((0.0, 0.0), ("free",), "as many")],
)
def test_wrong_operating_points(velocity: tuple[float, ...], contact: tuple[str, ...], says: str) -> None:
    with pytest.raises(InputError, match=says):
        OperatingPoint((0.0,), velocity, contact)  # type: ignore[arg-type]


def test_gravity_gives_stiffness() -> None:
    arm = replace(two_links(), joints=two_links().joints[:1])
    plant = linearise(arm, free(arm, loop())).system
    inertia = 4.0 * (0.17**2 + 0.02**2) + 0.06 + 0.15
    assert np.abs(plant.poles().imag).max() ** 2 == pytest.approx(4.0 * 9.81 * 0.17 / inertia, rel=1e-9)
